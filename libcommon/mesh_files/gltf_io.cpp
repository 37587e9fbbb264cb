#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/mesh_files/gltf_accessor.h"
#include "libcommon/mesh_files/gltf_model.h"
#include "libcommon/mesh_files/gltf_nodes.h"
#include "libcommon/mesh_files/gltf_uvs.h"
#include "libcommon/mesh_files/mesh_builder.h"
#include "libcommon/mesh_files/mesh_formats.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"

namespace patinate {

namespace {

using Matrix4 = Eigen::Matrix4d;

/// n is carried by the cofactors of the linear part, which are sign(det) |det| A^-T and exist for every A.
Eigen::Matrix3d normal_matrix(const Eigen::Matrix3d& a) {
  Eigen::Matrix3d cofactors;
  cofactors.col(0) = a.col(1).cross(a.col(2));
  cofactors.col(1) = a.col(2).cross(a.col(0));
  cofactors.col(2) = a.col(0).cross(a.col(1));
  return a.determinant() < 0.0 ? Eigen::Matrix3d(-cofactors) : cofactors;
}

/// Transforms that move the vertices of a node: its own, or those of the joints of its skin.
struct Placement {
  Matrix4 scene_from_node;
  std::vector<Matrix4> scene_from_bind;  ///< One a joint; empty: there is no skin.
};

constexpr std::size_t kMaxVertices = 300'000'000;  ///< Most vertices of all nodes and instances.

class GltfReader {
 public:
  GltfReader(const std::filesystem::path& path, std::vector<std::string>* notes)
      : file_(path.string()),
        loaded_(load_gltf_model(path, document_)),
        model_(*loaded_),
        builder_(file_),
        notes_(notes) {}

  Mesh read() {
    note_what_is_left_out();
    scene_from_node_ = gltf_scene_from_nodes(model_);
    visit_nodes();
    if (num_faces_ == 0) {
      throw IoError(file_, num_other_ > 0 ? "no faces, only points or lines (a point cloud); a surface is needed"
                                          : "no faces in its scene; a surface is needed");
    }
    return builder_.finish();
  }

 private:
  void note(const std::string& text) const {
    if (notes_ != nullptr && std::find(notes_->begin(), notes_->end(), text) == notes_->end()) notes_->push_back(text);
  }

  void note_what_is_left_out() const {
    if (model_.scenes.size() > 1)
      note("of its " + std::to_string(model_.scenes.size()) + " scenes only number " +
           std::to_string(std::max(0, model_.defaultScene)) + " is read");
    if (!model_.animations.empty()) note("its animations are not looked at: it is read at rest");
  }

  [[nodiscard]] std::vector<int> root_nodes() const {
    if (model_.scenes.empty()) return gltf_parentless_nodes(model_);
    const auto scene = static_cast<std::size_t>(std::max(0, model_.defaultScene));
    if (scene >= model_.scenes.size()) throw IoError(file_, "its default scene does not exist");
    return model_.scenes[scene].nodes;
  }

  void visit_nodes() {
    std::vector<int> waiting;
    const auto push = [&waiting](const std::vector<int>& nodes) {
      waiting.insert(waiting.end(), nodes.rbegin(), nodes.rend());
    };
    push(root_nodes());
    std::vector<char> is_visited(model_.nodes.size(), 0);
    while (!waiting.empty()) {
      const int index = waiting.back();
      waiting.pop_back();
      if (index < 0 || static_cast<std::size_t>(index) >= model_.nodes.size()) {
        throw IoError(file_, "node " + std::to_string(index) + " does not exist");
      }
      if (std::exchange(is_visited[index], char{1})) {
        throw IoError(
            file_, "node " + std::to_string(index) + " has two parents or is its own ancestor; nodes must form a tree");
      }
      const tinygltf::Node& node = model_.nodes[index];
      if (node.mesh >= 0) add_node(node, index);
      push(node.children);
    }
  }

  void add_node(const tinygltf::Node& node, int index) {
    Placement placement{scene_from_node_[index], joints_of(node, index)};
    const std::vector<Matrix4> instances = gltf_instances(file_, document_, model_, index);
    if (instances.empty()) add_mesh(node, index, placement);
    for (const Matrix4& node_from_instance : instances) {
      add_mesh(node, index, {placement.scene_from_node * node_from_instance, placement.scene_from_bind});
    }
  }

  /// Where the skin's joints take the vertices at rest: the place of the node itself does not count.
  [[nodiscard]] std::vector<Matrix4> joints_of(const tinygltf::Node& node, int index) const {
    if (node.skin < 0) return {};
    const std::string what = "node " + std::to_string(index) + ": skin " + std::to_string(node.skin);
    if (static_cast<std::size_t>(node.skin) >= model_.skins.size()) throw IoError(file_, what + " does not exist");
    const tinygltf::Skin& skin = model_.skins[node.skin];
    std::optional<GltfAccessor> inverse_bind;
    if (skin.inverseBindMatrices >= 0) {
      inverse_bind.emplace(file_, model_, skin.inverseBindMatrices, what + ": inverseBindMatrices");
      if (inverse_bind->num_components() != 16 || inverse_bind->size() < skin.joints.size())
        throw IoError(file_, what + ": there is not a 4 x 4 matrix for every joint");
    }
    std::vector<Matrix4> joints;
    for (std::size_t k = 0; k < skin.joints.size(); ++k) {
      const auto joint = static_cast<std::size_t>(skin.joints[k]);
      if (skin.joints[k] < 0 || joint >= model_.nodes.size())
        throw IoError(file_, what + ": joint " + std::to_string(skin.joints[k]) + " does not exist");
      Matrix4 joint_from_bind = Matrix4::Identity();
      for (int c = 0; inverse_bind && c < 16; ++c) joint_from_bind.data()[c] = inverse_bind->value(k, c);
      joints.push_back(scene_from_node_[joint] * joint_from_bind);
    }
    return joints;
  }

  void add_mesh(const tinygltf::Node& node, int index, const Placement& placement) {
    if (static_cast<std::size_t>(node.mesh) >= model_.meshes.size()) {
      throw IoError(file_, "mesh " + std::to_string(node.mesh) + " does not exist");
    }
    const tinygltf::Mesh& mesh = model_.meshes[node.mesh];
    const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
    std::string name = node.name.empty() ? mesh.name : node.name;
    if (name.empty()) name = "node " + std::to_string(index);
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      std::string material;
      if (primitive.material >= 0 && static_cast<std::size_t>(primitive.material) < model_.materials.size()) {
        material = model_.materials[primitive.material].name;
        if (material.empty()) material = "material " + std::to_string(primitive.material);
      }
      builder_.set_surface(name, material);
      add_primitive(primitive, "mesh " + std::to_string(node.mesh), material, weights, placement);
    }
  }

  void add_primitive(const tinygltf::Primitive& primitive, const std::string& what, const std::string& material,
                     const std::vector<double>& weights, const Placement& placement) {
    if (primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES) {
      ++num_other_;
      return;
    }
    if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
      throw IoError(file_, what + ": primitive mode " + std::to_string(primitive.mode) + " is unknown; use 0 to 6");
    }
    bool is_mirrored = false;
    const std::vector<MeshBuilder::Corner> vertices =
        placed(read_vertices(primitive, what, material, weights), primitive, what, placement, is_mirrored);
    const std::vector<std::size_t> indices = read_indices(primitive, what, vertices.size());
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      if (is_mirrored) std::swap(b, c);
      const std::array<MeshBuilder::Corner, 3> corners{vertices[indices[a]], vertices[indices[b]],
                                                       vertices[indices[c]]};
      builder_.add_polygon(corners);
      ++num_faces_;
    };
    if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      for (std::size_t i = 0; i + 2 < indices.size(); ++i) i % 2 == 0 ? add(i, i + 1, i + 2) : add(i + 1, i, i + 2);
    } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      for (std::size_t i = 1; i + 1 < indices.size(); ++i) add(0, i, i + 1);
    } else {
      for (std::size_t i = 0; i + 2 < indices.size(); i += 3) add(i, i + 1, i + 2);
    }
  }

  using Attributes = std::map<std::string, int>;

  /// @param count  That it must have; 0 = any. @returns nothing if there is no such attribute.
  [[nodiscard]] std::optional<GltfAccessor> attribute(const Attributes& attributes, const std::string& name,
                                                      int num_components, std::size_t count,
                                                      const std::string& what) const {
    const auto found = attributes.find(name);
    if (found == attributes.end()) return std::nullopt;
    GltfAccessor values(file_, model_, found->second, what + ": " + name);
    if (values.num_components() != num_components) {
      throw IoError(file_, what + ": " + name + " has " + std::to_string(values.num_components()) +
                               " components; expected " + std::to_string(num_components));
    }
    if (count > 0 && values.size() != count) {
      throw IoError(file_, what + ": " + name + " has " + std::to_string(values.size()) + " entries; POSITION has " +
                               std::to_string(count));
    }
    return values;
  }

  /// The UVs that the primitive's material is laid over by; where no texture says, the first that there are.
  [[nodiscard]] GltfUvs choose_uvs(const tinygltf::Primitive& primitive, const std::string& material) const {
    bool is_alike = true;
    GltfUvs uvs;
    const Json& materials = gltf_member(document_, "/materials");
    if (materials.is_array() && primitive.material >= 0 &&
        static_cast<std::size_t>(primitive.material) < materials.size())
      uvs = gltf_uvs_of(materials[primitive.material], is_alike);
    if (!is_alike)
      note("material `" + material + "` has textures with different UVs; those of its base color are read");
    constexpr int kMaxSets = 8;
    for (int set = 0; !uvs.set && set < kMaxSets; ++set) {
      if (primitive.attributes.contains("TEXCOORD_" + std::to_string(set))) uvs.set = set;
    }
    return uvs;
  }

  /// In the mesh's own coordinates, with v up.
  [[nodiscard]] std::vector<MeshBuilder::Corner> read_vertices(const tinygltf::Primitive& primitive,
                                                               const std::string& what, const std::string& material,
                                                               const std::vector<double>& weights) {
    const auto positions = attribute(primitive.attributes, "POSITION", 3, 0, what);
    if (!positions) throw IoError(file_, what + ": has no POSITION");
    num_vertices_ += positions->size();
    if (num_vertices_ > kMaxVertices) throw IoError(file_, "more than " + std::to_string(kMaxVertices) + " vertices");
    const auto normals = attribute(primitive.attributes, "NORMAL", 3, positions->size(), what);
    const GltfUvs choice = choose_uvs(primitive, material);
    const std::string uv_name = "TEXCOORD_" + std::to_string(choice.set.value_or(0));
    const auto uvs = attribute(primitive.attributes, uv_name, 2, positions->size(), what);
    std::vector<MeshBuilder::Corner> vertices(positions->size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      vertices[i].position = positions->vector<3>(i);
      if (normals) vertices[i].normal = normals->vector<3>(i);
      if (uvs) vertices[i].uv = uvs->vector<2>(i);
    }
    for (std::size_t k = 0; k < std::min(weights.size(), primitive.targets.size()); ++k) {
      if (weights[k] != 0.0) add_morph_target(primitive.targets[k], weights[k], uv_name, what, vertices);
    }
    for (MeshBuilder::Corner& vertex : vertices) {
      if (!vertex.uv) continue;
      const Vec2 uv = choice.uv_from_file * *vertex.uv;
      vertex.uv = Vec2(uv.x(), 1.0 - uv.y());
    }
    return vertices;
  }

  void add_morph_target(const Attributes& target, double weight, const std::string& uv_name, const std::string& what,
                        std::vector<MeshBuilder::Corner>& vertices) const {
    const std::string morphed = what + ": morph target";
    const auto positions = attribute(target, "POSITION", 3, vertices.size(), morphed);
    const auto normals = attribute(target, "NORMAL", 3, vertices.size(), morphed);
    const auto uvs = attribute(target, uv_name, 2, vertices.size(), morphed);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      MeshBuilder::Corner& vertex = vertices[i];
      if (positions) vertex.position += weight * positions->vector<3>(i);
      if (normals && vertex.normal) *vertex.normal += weight * normals->vector<3>(i);
      if (uvs && vertex.uv) *vertex.uv += weight * uvs->vector<2>(i);
    }
  }

  /// @param is_mirrored  Becomes whether triangles turn over.
  [[nodiscard]] std::vector<MeshBuilder::Corner> placed(std::vector<MeshBuilder::Corner> vertices,
                                                        const tinygltf::Primitive& primitive, const std::string& what,
                                                        const Placement& placement, bool& is_mirrored) const {
    const Joints joints = placement.scene_from_bind.empty() ? Joints{} : read_joints(primitive, what, vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Matrix4 matrix = joints.empty() ? placement.scene_from_node : blended(joints, i, what, placement);
      const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
      if (i == 0) is_mirrored = linear.determinant() < 0.0;
      vertices[i].position = linear * vertices[i].position + matrix.topRightCorner<3, 1>();
      if (vertices[i].normal) vertices[i].normal = normal_matrix(linear) * *vertices[i].normal;
    }
    return vertices;
  }

  using Joints = std::vector<std::pair<GltfAccessor, GltfAccessor>>;  ///< Numbers and weights, four at a time.

  [[nodiscard]] Joints read_joints(const tinygltf::Primitive& primitive, const std::string& what,
                                   std::size_t count) const {
    Joints joints;
    for (int set = 0;; ++set) {
      const std::string number = std::to_string(set);
      const auto numbers = attribute(primitive.attributes, "JOINTS_" + number, 4, count, what);
      const auto weights = attribute(primitive.attributes, "WEIGHTS_" + number, 4, count, what);
      if (!numbers || !weights) return joints;
      joints.emplace_back(*numbers, *weights);
    }
  }

  /// Joints' matrices of a vertex by their weights, which are made to sum to 1; without any, the first joint's.
  [[nodiscard]] Matrix4 blended(const Joints& joints, std::size_t vertex, const std::string& what,
                                const Placement& placement) const {
    Matrix4 sum = Matrix4::Zero();
    double total = 0.0;
    for (const auto& [numbers, weights] : joints) {
      for (int c = 0; c < 4; ++c) {
        const double joint = numbers.value(vertex, c), weight = weights.value(vertex, c);
        if (!(weight > 0.0)) continue;
        if (!(joint >= 0.0 && joint < static_cast<double>(placement.scene_from_bind.size())))
          throw IoError(file_, what + ": joint " + short_number_text(joint) + " is out of range; the skin has " +
                                   std::to_string(placement.scene_from_bind.size()));
        sum += weight * placement.scene_from_bind[static_cast<std::size_t>(joint)];
        total += weight;
      }
    }
    return total > 0.0 ? Matrix4(sum / total) : placement.scene_from_bind.front();
  }

  std::vector<std::size_t> read_indices(const tinygltf::Primitive& primitive, const std::string& what,
                                        std::size_t num_vertices) const {
    std::vector<std::size_t> indices;
    if (primitive.indices < 0) {
      for (std::size_t i = 0; i < num_vertices; ++i) indices.push_back(i);
      return indices;
    }
    const GltfAccessor values(file_, model_, primitive.indices, what + ": indices");
    if (!values.is_index()) throw IoError(file_, what + ": indices are not unsigned integers");
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto index = static_cast<std::size_t>(values.value(i, 0));
      if (index >= num_vertices) {
        throw IoError(file_, what + ": vertex index " + std::to_string(index) + " is out of range; there are " +
                                 std::to_string(num_vertices) + " vertices");
      }
      indices.push_back(index);
    }
    return indices;
  }

  std::string file_;
  Json document_;
  std::unique_ptr<tinygltf::Model> loaded_;
  const tinygltf::Model& model_;
  MeshBuilder builder_;
  std::vector<std::string>* notes_;
  std::vector<Matrix4> scene_from_node_;
  std::size_t num_vertices_ = 0;
  std::int64_t num_faces_ = 0;
  std::int64_t num_other_ = 0;
};

}  // namespace

Mesh read_gltf(const std::filesystem::path& path, std::vector<std::string>* notes) {
  return GltfReader(path, notes).read();
}

}  // namespace patinate
