/// \file
/// Gathers on devices, without the ways there and back.
#pragma once

namespace patinate::benchmarks {

/// A line for every device and format: what a gather of a 4k atlas moves a second, and its share of what a plain copy
/// moves there, both by the device's clock.
void measure_lookup_kernels();

}  // namespace patinate::benchmarks
