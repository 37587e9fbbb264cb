/// \file
/// The dominant mode of the local histogram: fills cracks without blurring what surrounds them.
#pragma once

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Settings of mode_filter().
struct ModeFilterOptions {
  double spatial_sigma_px = 20.0;  ///< Gaussian window; >= 0.5. Larger than the widest crack.
  double range_sigma = 0.02;  ///< Histogram smoothing, in units of the image's value; > 0. At least one bin is used.
  int num_bins = 128;         ///< [16, 4096] over the image's range of values. Peaks are refined between bins.
};
void describe(OptionVisitor& v, ModeFilterOptions& o);

/// Dominant mode of the local histogram at every pixel [Kass and Solomon 2010, "Smoothed local histogram filters", sec.
/// 3].
///
/// out(p) = argmax_v sum_q G_spatial(|p - q|) G_range(v - in(q)). Unlike a bilateral filter it does not average across
/// gaps: where the paint varies by less than range_sigma in the window, a crack covering less than half of it changes
/// nothing. On sloping paint the share a crack may cover falls with slope x spatial_sigma_px / range_sigma.
///
/// Layers of the histogram are sampled spatial_sigma_px / 2.5 apart (linear weights in and out, whose variance is taken
/// off the Gaussian's), as the window passes no finer detail; they are made and used band by band.
/// @param in    H x W x 1, finite inside `mask`.
/// @param mask  H x W, 0 = ignored; may be empty.
/// @returns     H x W x 1; 0 outside the mask.
/// @throws InvalidInput if sizes differ, the mask is empty everywhere, a value is not finite, or an option is out of
/// range. Cost: O(H W num_bins), not rising with spatial_sigma_px; at most about 100 MB beside the images. Same bits
/// for any number of threads.
[[nodiscard]] ImageF mode_filter(const ImageF& in, const ImageU8& mask, const ModeFilterOptions& options = {},
                                 const RunControl& control = {});

}  // namespace patinate::capture
