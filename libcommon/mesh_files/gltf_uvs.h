/// \file
/// What a glTF's materials say of UVs. For the reader of glTF.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "patinate/core/json.h"

namespace patinate {

/// UVs of a primitive: those that its material's textures are laid over by.
struct GltfUvs {
  std::optional<int> set;  ///< Number of TEXCOORD_n; none = no texture says.
  Eigen::Affine2d uv_from_file = Eigen::Affine2d::Identity();
};

/// UVs of the base color, or else of the first texture that there is.
/// @param is_alike  Becomes whether all textures have these.
[[nodiscard]] GltfUvs gltf_uvs_of(const Json& material, bool& is_alike);

/// The value at a JSON pointer, null where there is none.
[[nodiscard]] const Json& gltf_member(const Json& json, const char* pointer);
/// The number at a JSON pointer.
[[nodiscard]] double gltf_number(const Json& json, const char* pointer, double otherwise);

}  // namespace patinate
