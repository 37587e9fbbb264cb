/// \file
/// Where the highlights that were fitted are believed. Inside of unlighting only.
#pragma once

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

/// What the samples of one texel cost under a fit: the sum over channels of squared residuals in standard deviations,
/// and of the logarithms of what `samples.variance` is over `plain_variance`, lamp by lamp, and never more for a lamp
/// than what it costs to reject it.
/// @param samples  As fit_texel() left them; @param plain_variance  of the same samples, before highlights made them
/// less certain.
[[nodiscard]] double robust_cost(const TexelSamples& samples, const std::vector<double>& plain_variance,
                                 const TexelFit& fit, const TexelFitOptions& options);

/// Fades work.specular where it is not shared: the lobe of a material makes nearly all of its texels cost less than no
/// lobe does. One that stands for a mixture of materials, for highlights of a few, or for shadows and edges that no
/// model knows, serves those at the cost of the others; they are better rejected. The share of texels that cost less
/// counts, within specular_window_px or within a dozen pixels, where it is larger; below 3/4 nothing is left of the
/// highlight, from 17/20 on all of it.
void keep_shared_highlights(UnlightWork& work, const RunControl& control);

}  // namespace patinate::capture
