/// \file
/// What a history's frames hold beside color, at any time and in the surface's own terms: relief, gloss, height.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "patinate/history/history_sampling.h"

namespace patinate {

enum class MaterialMap {
  Normal,     ///< Unit, tangent space: x to the right in the image, y up, z out of the surface. 3 channels.
  Roughness,  ///< Of the highlight, [0, 1]. 1 channel.
  Specular,   ///< Its strength (F0), >= 0. 1 channel.
  Height,     ///< mm. 1 channel.
};
inline constexpr std::array<std::string_view, 4> kMaterialMapNames{"normal", "roughness", "specular", "height"};

/// What stands where nobody knows: a plain, rather dull dielectric.
inline constexpr float kUnknownRoughness = 0.8f;
inline constexpr float kUnknownSpecular = 0.04f;

/// Those that at least one frame has, in the order of MaterialMap; height also as a map that is constant in time. The
/// constant map `normal` is the object's shape, not the material's relief, and none of them.
[[nodiscard]] std::vector<MaterialMap> material_maps(const HistoryFacts& history);

/// Normals of the scanned world in the tangent space of the surface that the photographs show.
///
/// z is the surface's normal, x what of the image's x direction lies in the surface, y = z x x. Without positions the
/// image itself is the surface: x right, y up, z to the viewer, and `normals` come back as they are, unit.
/// @param normals   H x W x 3, any length; 0 = unknown, which gives (0, 0, 1).
/// @param position  H x W x 3 in mm; may be empty. @param surface  Its normals, H x W x 3; 0 = no surface. Empty with
/// `position`.
/// @throws InvalidInput if sizes or channels differ.
[[nodiscard]] ImageF tangent_space_normals(const ImageF& normals, const ImageF& position, const ImageF& surface);

/// A map at any time: between the frames that have it, as sample() is between frames; at such a frame's time what it
/// holds. Normals between frames are the blend, unit again. Where only one of the two frames knows a value it counts
/// alone.
/// @throws InvalidInput if no frame has it, listing those there are, or `time` is NaN; IoError.
[[nodiscard]] ImageF sample_material_map(const History& history, MaterialMap map, double time, Between between);

}  // namespace patinate
