/// \file
/// Strength and roughness of the highlights that samples show beside the diffuse light. Inside of unlighting only.
#pragma once

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

struct SpecularFit {
  SpecularLobe lobe = SpecularLobe::Ggx;
  ImageF values = {};  ///< H x W x 2: strength >= 0, roughness; 0, 0 where nothing is determined near.
};

/// For each of a series of roughnesses, strength is the least-squares factor of the lobe, with albedo and normal of
/// every texel eliminated (so that a wrong albedo or normal is not taken for a highlight); sums over texels within
/// specular_window_px choose the roughness (that explains most) and the strength, from which a texel's own samples may
/// move the strength by some 30 %.
/// @param fitted  Of the last fit: its normals, mask and samples (all but shadowed and invalid ones count).
/// Of the two forms of a lobe the one is taken that explains more over all texels.
[[nodiscard]] SpecularFit fit_specular(const UnlightWork& work, const UnlightResult& fitted, const RunControl& control);

}  // namespace patinate::capture
