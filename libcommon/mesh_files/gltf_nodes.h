/// \file
/// Where the nodes of a glTF stand. For the reader of glTF.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "patinate/core/json.h"

namespace tinygltf {
class Model;
}

namespace patinate {

[[nodiscard]] std::vector<int> gltf_parentless_nodes(const tinygltf::Model& model);
/// Transforms of all nodes, as joints may lie outside the scene; those of a ring stay where they are.
[[nodiscard]] std::vector<Eigen::Matrix4d> gltf_scene_from_nodes(const tinygltf::Model& model);
/// EXT_mesh_gpu_instancing: node from instance. Empty: the node has its mesh once. @throws IoError
[[nodiscard]] std::vector<Eigen::Matrix4d> gltf_instances(const std::string& file, const Json& document,
                                                          const tinygltf::Model& model, int index);

}  // namespace patinate
