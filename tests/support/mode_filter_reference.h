/// \file
/// Slow, plain forms of the mode filter: the truth that mode_filter() is tested against, and the form that the source
/// uses.
#pragma once

#include "patinate/capture/thickness.h"

namespace patinate::capture {

/// sum_q G_spatial(|p - q|) G_range(value - in(q)) / sum_q G_spatial(|p - q|) over the pixels q inside the mask: the
/// smoothed local histogram at pixel (x, y). In [0, 1]; 0 when no pixel is inside. Cost: O(H W).
[[nodiscard]] double local_histogram(const ImageF& in, const ImageU8& mask, int x, int y, double value,
                                     const ModeFilterOptions& options);

/// What mode_filter() approximates, by exhaustive search (values range_sigma / 8 apart, then golden section) of the
/// exact local_histogram(). `num_bins` is not used. Same contract as mode_filter(). Cost: O((H W)^2 range /
/// range_sigma).
[[nodiscard]] ImageF mode_filter_reference(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options = {},
                                           const RunControl& control = {});

/// The bilateral form [van de Weijer and van den Boomgaard 2001, "Local mode filtering"]: v <- sum G_spatial G_range(v
/// - in(q)) in(q) / sum G_spatial G_range(v - in(q)) from v = in(p) until it moves by less than 1e-4 range_sigma. Its
/// first step is the bilateral filter; its end is the mode *nearest* to the pixel's own value, so a wide enough crack
/// keeps its own value, which is why mode_filter() takes the dominant mode. Same contract as mode_filter(). Cost: O((H
/// W)^2).
[[nodiscard]] ImageF bilateral_mode_filter(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options = {},
                                           const RunControl& control = {});

}  // namespace patinate::capture
