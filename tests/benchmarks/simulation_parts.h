/// \file
/// Parts of simulation_benchmark: one function each, listed in its main().
#pragma once

namespace patinate::benchmarks {

/// Rays/s against Embree, incoherent, one thread.
void rays();
/// Segments/s of trace() and respond() alone.
void gammatons();

}  // namespace patinate::benchmarks
