#include "libcommon/mesh_files/gltf_nodes.h"

#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libcommon/mesh_files/gltf_accessor.h"
#include "libcommon/mesh_files/gltf_uvs.h"
#include "patinate/core/error.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

namespace {

Eigen::Matrix4d parent_from_node(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  if (node.translation.size() == 3) transform.translate(Eigen::Map<const Vec3>(node.translation.data()));
  if (node.rotation.size() == 4) {
    const auto& q = node.rotation;
    transform.rotate(Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized());
  }
  if (node.scale.size() == 3) transform.scale(Eigen::Map<const Vec3>(node.scale.data()));
  return transform.matrix();
}

}  // namespace

std::vector<int> gltf_parentless_nodes(const tinygltf::Model& model) {
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes) {
    for (int child : node.children) {
      if (child >= 0 && static_cast<std::size_t>(child) < is_child.size()) is_child[child] = true;
    }
  }
  std::vector<int> roots;
  for (std::size_t i = 0; i < is_child.size(); ++i) {
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

std::vector<Eigen::Matrix4d> gltf_scene_from_nodes(const tinygltf::Model& model) {
  std::vector<Eigen::Matrix4d> scene_from_node(model.nodes.size(), Eigen::Matrix4d::Identity());
  std::vector<char> is_placed(model.nodes.size(), 0);
  std::vector<std::pair<int, Eigen::Matrix4d>> waiting;
  for (int root : gltf_parentless_nodes(model)) waiting.emplace_back(root, Eigen::Matrix4d::Identity());
  while (!waiting.empty()) {
    const auto [index, scene_from_parent] = waiting.back();
    waiting.pop_back();
    const auto i = static_cast<std::size_t>(index);
    if (index < 0 || i >= model.nodes.size() || std::exchange(is_placed[i], char{1})) continue;
    scene_from_node[i] = scene_from_parent * parent_from_node(model.nodes[i]);
    for (int child : model.nodes[i].children) waiting.emplace_back(child, scene_from_node[i]);
  }
  return scene_from_node;
}

std::vector<Eigen::Matrix4d> gltf_instances(const std::string& file, const Json& document, const tinygltf::Model& model,
                                            int index) {
  const std::string number = std::to_string(index);
  const Json& attributes =
      gltf_member(document, ("/nodes/" + number + "/extensions/EXT_mesh_gpu_instancing/attributes").c_str());
  if (!attributes.is_object()) return {};
  const std::string what = "node " + number + ": instances";
  std::optional<std::size_t> count;
  const auto attribute = [&](const char* name, int num_components) -> std::optional<GltfAccessor> {
    if (!attributes.contains(name)) return std::nullopt;
    const double accessor = gltf_number(attributes[name], "", -1.0);
    GltfAccessor values(file, model, static_cast<int>(std::clamp(accessor, -1.0, 1e9)), what + ": " + name);
    if (values.num_components() != num_components || values.size() != count.value_or(values.size()))
      throw IoError(file, what + ": " + name + " has " + std::to_string(values.size()) + " entries of " +
                              std::to_string(values.num_components()) + " components; expected " +
                              std::to_string(count.value_or(values.size())) + " of " + std::to_string(num_components));
    count = values.size();
    return values;
  };
  const auto translations = attribute("TRANSLATION", 3), rotations = attribute("ROTATION", 4),
             scales = attribute("SCALE", 3);
  if (!count) throw IoError(file, what + ": have no TRANSLATION, ROTATION or SCALE");
  std::vector<Eigen::Matrix4d> instances(*count);
  for (std::size_t i = 0; i < instances.size(); ++i) {
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (translations) transform.translate(translations->vector<3>(i));
    if (rotations) transform.rotate(Eigen::Quaterniond(rotations->vector<4>(i)).normalized());
    if (scales) transform.scale(scales->vector<3>(i));
    instances[i] = transform.matrix();
  }
  return instances;
}

}  // namespace patinate
