#include "libcommon/mesh_files/gltf_uvs.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace patinate {

namespace {

/// KHR_texture_transform with its rotation counter-clockwise where v points down, as all programs have it: the sign in
/// the specification's example code is wrong (KhronosGroup/glTF issue 1563).
GltfUvs uvs_of_texture(const Json& texture) {
  GltfUvs uvs{.set = static_cast<int>(std::clamp(gltf_number(texture, "/texCoord", 0.0), 0.0, 1000.0))};
  const Json& transform = gltf_member(texture, "/extensions/KHR_texture_transform");
  if (!transform.is_object()) return uvs;
  uvs.set = static_cast<int>(std::clamp(gltf_number(transform, "/texCoord", *uvs.set), 0.0, 1000.0));
  uvs.uv_from_file =
      Eigen::Translation2d(gltf_number(transform, "/offset/0", 0.0), gltf_number(transform, "/offset/1", 0.0)) *
      Eigen::Rotation2Dd(-gltf_number(transform, "/rotation", 0.0)) *
      Eigen::Scaling(gltf_number(transform, "/scale/0", 1.0), gltf_number(transform, "/scale/1", 1.0));
  return uvs;
}

}  // namespace

GltfUvs gltf_uvs_of(const Json& material, bool& is_alike) {
  is_alike = true;
  std::optional<GltfUvs> chosen;
  for (const char* pointer :
       {"/pbrMetallicRoughness/baseColorTexture", "/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture",
        "/normalTexture", "/pbrMetallicRoughness/metallicRoughnessTexture", "/occlusionTexture", "/emissiveTexture"}) {
    const Json& texture = gltf_member(material, pointer);
    if (!texture.is_object()) continue;
    const GltfUvs uvs = uvs_of_texture(texture);
    if (!chosen) chosen = uvs;
    is_alike = is_alike && uvs.set == chosen->set && uvs.uv_from_file.isApprox(chosen->uv_from_file);
  }
  return chosen.value_or(GltfUvs{});
}

const Json& gltf_member(const Json& json, const char* pointer) {
  static const Json kNone;
  const Json::json_pointer at(pointer);
  return json.contains(at) ? json[at] : kNone;
}

double gltf_number(const Json& json, const char* pointer, double otherwise) {
  const Json& value = gltf_member(json, pointer);
  return value.is_number() ? value.get<double>() : otherwise;
}

}  // namespace patinate
