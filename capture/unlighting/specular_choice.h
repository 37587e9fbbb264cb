/// \file
/// Where the highlights that were fitted are believed. Inside of unlighting only.
#pragma once

#include <functional>

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

inline constexpr double kTold = 2.0;  ///< Standard deviations from which lamps tell one choice from another.

/// Cost of one texel's samples under a fit: the sum over channels of squared residuals in standard deviations,
/// and of the logarithms of what `samples.variance` is over `plain_variance`, lamp by lamp, and never more for a lamp
/// than what it costs to reject it.
/// @param samples  As fit_texel() left them; @param plain_variance  of the same samples, before highlights made them
/// less certain.
[[nodiscard]] double robust_cost(const TexelSamples& samples, const std::vector<double>& plain_variance,
                                 const TexelFit& fit, const TexelFitOptions& options);

/// Leave-one-lamp-out cost: each lamp's samples under the fit to the others; of many lamps three to five are left out.
/// @param first  Any number >= 0: from texel to texel another, so that every lamp has its turn.
/// @returns the mean over lamps; negative where a fit without one of them does not determine the texel.
[[nodiscard]] double left_out_cost(TexelSamples& samples, const std::vector<double>& plain_variance,
                                   const TexelFitOptions& options, int first);

/// The mean over lamps of what `cost` says of one under the fit to the others; the same lamps as left_out_cost().
[[nodiscard]] double left_out_mean(TexelSamples& samples, const TexelFitOptions& options, int first,
                                   const std::function<double(const TexelFit&, int lamp)>& cost);

/// Fades work.specular where the neighborhood does not foretell its lamps better with it: the lobe of a material does.
/// One that stands for a mixture of materials, for highlights of a few texels, or for shadows and edges that no model
/// knows, serves those at the cost of the others; they are better rejected. What left-out lamps cost less is summed
/// within specular_window_px or within a dozen pixels, whichever is clearer; where it is 0 or less nothing is left of
/// the highlight, from two of its standard deviations on all of it. @returns whether any has faded.
bool keep_shared_highlights(UnlightWork& work, const RunControl& control);

}  // namespace patinate::capture
