/// \file
/// What a history shows at any time, between its frames too: color, and what frames hold beside it, relief, gloss and
/// height, in the surface's own terms.
#pragma once

#include <array>
#include <string_view>

#include "patinate/core/options.h"
#include "patinate/history/history_value.h"

namespace patinate {

/// Discrete treatments (cleaned, varnished) are not a smooth film: a blend of them shows a state that never was.
enum class Between {
  Blend,    ///< The two frames around, weighted by time.
  Hold,     ///< The last frame at or before.
  Nearest,  ///< The frame nearest in time; halfway the later one.
};

struct SamplingOptions {
  Between between = Between::Blend;  ///< What is shown between two frames.
};
void describe(OptionVisitor& v, SamplingOptions& o);

/// Where a time falls; the fraction is 0 but for Blend. @throws InvalidInput if `time` is NaN.
[[nodiscard]] TimePosition locate(const History& history, double time, Between between);

/// H x W x 3, linear: the history at any time. Blend is History::sample(). @throws as it does.
[[nodiscard]] ImageF sample(const History& history, double time, Between between);

enum class MaterialMap {
  Normal,     ///< Unit, tangent space: x to the right in the image, y up, z out of the surface. 3 channels.
  Roughness,  ///< Of the highlight, [0, 1]. 1 channel.
  Specular,   ///< Its strength (F0), >= 0. 1 channel.
  Height,     ///< mm. 1 channel.
  Stddev,     ///< Standard deviation of the color, linear; 0 = not known. 3 channels.
  Metalness,  ///< 0 = dielectric, 1 = metal. 1 channel.
  Tint,  ///< Color of the mirror, [0, 1]: what metal reflects at normal incidence, else a factor of its strength. Where
         ///< nobody knows it: white, and of metal the frame's color. 3 channels.
};
inline constexpr std::array<std::string_view, 7> kMaterialMapNames{"normal", "roughness", "specular", "height",
                                                                   "stddev", "metalness", "tint"};

/// Values used where a property is unknown: a plain, rather matte dielectric.
inline constexpr float kUnknownRoughness = 0.8f;
inline constexpr float kUnknownSpecular = 0.04f;

/// Those that at least one frame has, in the order of MaterialMap; height, roughness, specular, metalness and tint also
/// as maps that are constant in time. The constant map `normal` is the object's shape, not the material's relief, and
/// none of them.
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

/// Samples a map at any time, as sample() does between frames; at the time of a frame, the frame's values. Normals are
/// blended and normalized; deviations are those of a blend of independent frames. If only one of two frames knows a
/// value, that value is used. (@throws unchanged.)
[[nodiscard]] ImageF sample_material_map(const History& history, MaterialMap map, double time, Between between);

/// Base color of the metallic-roughness model (glTF 2.0): H x W x 3. What is no metal has the history's color, metal
/// its tint. Without tint it is sample(). @throws as sample_material_map().
[[nodiscard]] ImageF sample_base_color(const History& history, double time, Between between);
/// Reflectance of nonmetals at normal incidence (F0): strength times tint, H x W x 3. Empty if the history has no
/// strength; use kUnknownSpecular then.
[[nodiscard]] ImageF sample_reflectance(const History& history, double time, Between between);
/// Packed as glTF's metallic-roughness texture: 1 (nothing is known of occlusion), roughness, metalness; H x W x 3.
/// @throws InvalidInput if the history knows neither; as sample_material_map().
[[nodiscard]] ImageF sample_orm(const History& history, double time, Between between);

}  // namespace patinate
