/// \file
/// What unlighting found of materials, as a history has it.
#pragma once

#include "patinate/capture/unlight.h"

namespace patinate::capture {

/// Maps of a frame: base color and F0 of docs/algorithms/appearance.md are made of them.
struct MaterialFrame {
  ImageF color;     ///< H x W x 3; of pure metal the color of its mirror.
  ImageF specular;  ///< H x W x 2: strength [0, 1] of what is no metal, roughness.
  ImageF tint;      ///< H x W x 3, [0, 1]: what the metal reflects; 0 where there is none.
};

/// Metal of one base color with the diffuse light beside it, weighted between both as glTF's converter of specular
/// colors does. What `render` draws of it reflects the measured F0 in the mean over channels, and the measured albedo
/// where metalness is of metal_share().
/// @param result  Of SpecularMode::Material.
[[nodiscard]] MaterialFrame material_frame(const UnlightResult& result);

}  // namespace patinate::capture
