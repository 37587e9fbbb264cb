/// \file
/// Strength and roughness of the highlights that samples show beside the diffuse light. Inside of unlighting only.
#pragma once

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

struct SpecularFit {
  ImageF values = {};  ///< H x W x 2: strength >= 0, roughness; 0, 0 where nothing is determined near.
  double gain = 0.0;   ///< Chi-square of the samples that it explains.
};

/// Highlights of a form. For each of a series of roughnesses, strength is the least-squares factor of the
/// lobe over all channels, with albedo and normal of every texel eliminated (so that a wrong albedo or normal is not
/// taken for a highlight); sums over texels within specular_window_px choose the roughness (that explains most) and the
/// strength.
/// @param fitted  Of the last fit, with the highlights (and their form) that work has: its normals, albedo, mask and
/// samples (all but shadowed and invalid ones count).
[[nodiscard]] SpecularFit fit_specular(const UnlightWork& work, const UnlightResult& fitted, const SpecularForm& form,
                                       const RunControl& control);

/// Gives work the highlights of its form that fit_specular() finds.
void fit_highlights(UnlightWork& work, const UnlightResult& fitted, const RunControl& control);

}  // namespace patinate::capture
