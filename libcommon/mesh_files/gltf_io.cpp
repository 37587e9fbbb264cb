#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/read_limit.h"
#include "libcommon/mesh_files/gltf_json.h"
#include "libcommon/mesh_files/mesh_builder.h"
#include "libcommon/mesh_files/mesh_formats.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

using Matrix4 = Eigen::Matrix4d;

bool ignore_image(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

/// What a glTF names is read as everything else is, and its names stand for nothing but themselves.
tinygltf::FsCallbacks files_beside(std::string* outside) {
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string& path, void* kept) {
    std::error_code error;
    if (may_read(path)) return std::filesystem::exists(path, error);
    if (auto& first = *static_cast<std::string*>(kept); first.empty()) first = path;
    return false;
  };
  callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string* problem, const std::string& path, void*) {
    try {
      const std::string bytes = read_file(path, kLargestGltf);
      out->assign(bytes.begin(), bytes.end());
      return true;
    } catch (const IoError& e) {
      *problem = std::string(e.what()).substr(path.size() + 2);
      return false;
    }
  };
  callbacks.user_data = outside;
  return callbacks;
}

/// tinygltf's errors as one line.
std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (std::size_t i = text.find('\n'); i != std::string::npos; i = text.find('\n', i)) text.replace(i, 1, "; ");
  return text;
}

tinygltf::Model load_model(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::string bytes = read_file(path, kLargestGltf);
  const bool is_binary = bytes.compare(0, 4, "glTF") == 0;
  (void)gltf_json(file, bytes);  // checked
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(&ignore_image, nullptr);
  std::string outside;
  loader.SetFsCallbacks(files_beside(&outside));
  tinygltf::Model model;
  std::string error, warning;
  const std::string folder = folder_of(path).string();
  const auto size = static_cast<unsigned int>(bytes.size());
  bool ok = false;
  try {
    ok = is_binary ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                                 reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
                   : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, folder);
  } catch (const std::bad_alloc&) {
    throw IoError(file, "is not valid glTF, or larger than memory");
  } catch (const std::length_error&) {
    throw IoError(file, "is not valid glTF: it gives a size that nothing can have");
  } catch (const std::exception&) {
    throw IoError(file, "is not valid glTF: its JSON does not hold what it should");
  }
  if (!ok && !outside.empty()) check_may_read(outside);
  if (!ok) throw IoError(file, "is not valid glTF: " + one_line(error.empty() ? "its JSON cannot be parsed" : error));
  return model;
}

/// One accessor, every bound checked.
class Values {
 public:
  Values(const std::string& file, const tinygltf::Model& model, int index, const std::string& what) {
    const auto fail = [&](const std::string& problem) {
      throw IoError(file, what + " (accessor " + std::to_string(index) + "): " + problem);
    };
    if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size()) fail("does not exist");
    const tinygltf::Accessor& a = model.accessors[static_cast<std::size_t>(index)];
    if (a.sparse.isSparse) fail("is sparse, which is not supported; export it without sparse accessors");
    if (a.bufferView < 0 || static_cast<std::size_t>(a.bufferView) >= model.bufferViews.size())
      fail("has no buffer view");
    const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(a.bufferView)];
    if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size()) fail("has no buffer");
    const std::vector<unsigned char>& bytes = model.buffers[static_cast<std::size_t>(view.buffer)].data;
    const int component_size = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType));
    num_components_ = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
    if (component_size <= 0 || num_components_ <= 0) fail("has an unknown component type");
    const auto element_size = static_cast<std::size_t>(component_size * num_components_);
    stride_ = view.byteStride == 0 ? element_size : view.byteStride;
    if (stride_ < element_size || stride_ > 65536) fail("has a wrong byteStride");
    if (view.byteLength > bytes.size() || view.byteOffset > bytes.size() - view.byteLength) {
      fail("its buffer view ends behind its buffer of " + std::to_string(bytes.size()) + " bytes");
    }
    count_ = a.count;
    if (count_ > view.byteLength || a.byteOffset > view.byteLength ||
        (count_ > 0 && (count_ - 1) * stride_ + element_size > view.byteLength - a.byteOffset)) {
      fail(std::to_string(a.count) + " elements do not fit into its buffer view of " + std::to_string(view.byteLength) +
           " bytes");
    }
    data_ = bytes.data() + view.byteOffset + a.byteOffset;
    component_ = a.componentType;
    is_normalized_ = a.normalized;
  }

  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] int num_components() const { return num_components_; }
  [[nodiscard]] bool is_index() const {
    return num_components_ == 1 &&
           (component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
            component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT || component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
  }
  template <int N>
  [[nodiscard]] Eigen::Matrix<double, N, 1> vector(std::size_t i) const {
    Eigen::Matrix<double, N, 1> v;
    for (int c = 0; c < N; ++c) v[c] = value(i, c);
    return v;
  }
  [[nodiscard]] double value(std::size_t i, int c) const {
    const unsigned char* element = data_ + i * stride_;
    const auto as = [&](auto x) {
      std::memcpy(&x, element + static_cast<std::size_t>(c) * sizeof(x), sizeof(x));
      if (!is_normalized_) return static_cast<double>(x);
      return std::max(static_cast<double>(x) / static_cast<double>(std::numeric_limits<decltype(x)>::max()), -1.0);
    };
    switch (component_) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return as(std::int8_t{});
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return as(std::uint8_t{});
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return as(std::int16_t{});
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return as(std::uint16_t{});
      case TINYGLTF_COMPONENT_TYPE_INT:
        return as(std::int32_t{});
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return as(std::uint32_t{});
      default:
        break;
    }
    float x = 0.0F;
    std::memcpy(&x, element + static_cast<std::size_t>(c) * sizeof(x), sizeof(x));
    return static_cast<double>(x);
  }

 private:
  const unsigned char* data_ = nullptr;
  std::size_t count_ = 0;
  std::size_t stride_ = 0;
  int num_components_ = 0;
  int component_ = 0;
  bool is_normalized_ = false;
};

Matrix4 parent_from_node(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return Eigen::Map<const Matrix4>(node.matrix.data());
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  if (node.translation.size() == 3) transform.translate(Eigen::Map<const Vec3>(node.translation.data()));
  if (node.rotation.size() == 4) {
    const auto& q = node.rotation;
    transform.rotate(Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized());
  }
  if (node.scale.size() == 3) transform.scale(Eigen::Map<const Vec3>(node.scale.data()));
  return transform.matrix();
}

/// n is carried by the cofactors of the linear part, which are sign(det) |det| A^-T and exist for every A.
Eigen::Matrix3d normal_matrix(const Eigen::Matrix3d& a) {
  Eigen::Matrix3d cofactors;
  cofactors.col(0) = a.col(1).cross(a.col(2));
  cofactors.col(1) = a.col(2).cross(a.col(0));
  cofactors.col(2) = a.col(0).cross(a.col(1));
  return a.determinant() < 0.0 ? Eigen::Matrix3d(-cofactors) : cofactors;
}

class GltfReader {
 public:
  explicit GltfReader(const std::filesystem::path& path)
      : file_(path.string()), model_(load_model(path)), builder_(file_) {}

  Mesh read() {
    for (const std::string& extension : model_.extensionsRequired) {
      if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression") {
        throw IoError(file_,
                      "needs the extension " + extension + ", which is not supported; export it without compression");
      }
    }
    visit_nodes();
    if (num_faces_ == 0) {
      throw IoError(file_, num_other_ > 0 ? "no faces, only points or lines (a point cloud); a surface is needed"
                                          : "no faces in its scene; a surface is needed");
    }
    return builder_.finish();
  }

 private:
  [[nodiscard]] std::vector<int> root_nodes() const {
    if (!model_.scenes.empty()) {
      const auto scene = static_cast<std::size_t>(std::max(0, model_.defaultScene));
      if (scene >= model_.scenes.size()) throw IoError(file_, "its default scene does not exist");
      return model_.scenes[scene].nodes;
    }
    std::vector<bool> is_child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes) {
      for (int child : node.children) {
        if (child >= 0 && static_cast<std::size_t>(child) < is_child.size())
          is_child[static_cast<std::size_t>(child)] = true;
      }
    }
    std::vector<int> roots;
    for (std::size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    return roots;
  }

  void visit_nodes() {
    std::vector<std::pair<int, Matrix4>> waiting;
    const auto push = [&waiting](const std::vector<int>& nodes, const Matrix4& parent) {
      for (auto it = nodes.rbegin(); it != nodes.rend(); ++it) waiting.emplace_back(*it, parent);
    };
    push(root_nodes(), Matrix4::Identity());
    std::vector<char> is_visited(model_.nodes.size(), 0);
    while (!waiting.empty()) {
      const auto [index, scene_from_parent] = waiting.back();
      waiting.pop_back();
      if (index < 0 || static_cast<std::size_t>(index) >= model_.nodes.size()) {
        throw IoError(file_, "node " + std::to_string(index) + " does not exist");
      }
      if (std::exchange(is_visited[static_cast<std::size_t>(index)], char{1})) {
        throw IoError(
            file_, "node " + std::to_string(index) + " has two parents or is its own ancestor; nodes must form a tree");
      }
      const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
      const Matrix4 scene_from_node = scene_from_parent * parent_from_node(node);
      if (node.mesh >= 0) add_mesh(node, index, scene_from_node);
      push(node.children, scene_from_node);
    }
  }

  void add_mesh(const tinygltf::Node& node, int index, const Matrix4& scene_from_node) {
    if (static_cast<std::size_t>(node.mesh) >= model_.meshes.size()) {
      throw IoError(file_, "mesh " + std::to_string(node.mesh) + " does not exist");
    }
    const tinygltf::Mesh& mesh = model_.meshes[static_cast<std::size_t>(node.mesh)];
    std::string name = node.name.empty() ? mesh.name : node.name;
    if (name.empty()) name = "node " + std::to_string(index);
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      std::string material;
      if (primitive.material >= 0 && static_cast<std::size_t>(primitive.material) < model_.materials.size()) {
        material = model_.materials[static_cast<std::size_t>(primitive.material)].name;
        if (material.empty()) material = "material " + std::to_string(primitive.material);
      }
      builder_.set_surface(name, material);
      add_primitive(primitive, "mesh " + std::to_string(node.mesh), scene_from_node);
    }
  }

  void add_primitive(const tinygltf::Primitive& primitive, const std::string& what, const Matrix4& scene_from_node) {
    if (primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES) {
      ++num_other_;
      return;
    }
    if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
      throw IoError(file_, what + ": primitive mode " + std::to_string(primitive.mode) + " is unknown; use 0 to 6");
    }
    const std::vector<MeshBuilder::Corner> vertices = read_vertices(primitive, what, scene_from_node);
    const std::vector<std::size_t> indices = read_indices(primitive, what, vertices.size());
    const bool is_mirrored = scene_from_node.topLeftCorner<3, 3>().determinant() < 0.0;
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

  std::vector<MeshBuilder::Corner> read_vertices(const tinygltf::Primitive& primitive, const std::string& what,
                                                 const Matrix4& scene_from_node) const {
    const auto attribute = [&](const char* name, int num_components, std::size_t count) -> std::optional<Values> {
      const auto found = primitive.attributes.find(name);
      if (found == primitive.attributes.end()) return std::nullopt;
      const Values values(file_, model_, found->second, what + ": " + name);
      if (values.num_components() != num_components) {
        throw IoError(file_, what + ": " + name + " has " + std::to_string(values.num_components()) +
                                 " components; expected " + std::to_string(num_components));
      }
      if (count > 0 && values.size() != count) {
        throw IoError(file_, what + ": " + name + " has " + std::to_string(values.size()) + " entries; POSITION has " +
                                 std::to_string(count));
      }
      return values;
    };
    const auto positions = attribute("POSITION", 3, 0);
    if (!positions) throw IoError(file_, what + ": has no POSITION");
    const auto normals = attribute("NORMAL", 3, positions->size());
    const auto uvs = attribute("TEXCOORD_0", 2, positions->size());
    const Eigen::Matrix3d linear = scene_from_node.topLeftCorner<3, 3>();
    const Vec3 translation = scene_from_node.topRightCorner<3, 1>();
    const Eigen::Matrix3d turn = normal_matrix(linear);
    std::vector<MeshBuilder::Corner> vertices(positions->size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      vertices[i].position = linear * positions->vector<3>(i) + translation;
      if (normals) vertices[i].normal = turn * normals->vector<3>(i);
      if (uvs) vertices[i].uv = Vec2(uvs->value(i, 0), 1.0 - uvs->value(i, 1));
    }
    return vertices;
  }

  std::vector<std::size_t> read_indices(const tinygltf::Primitive& primitive, const std::string& what,
                                        std::size_t num_vertices) const {
    std::vector<std::size_t> indices;
    if (primitive.indices < 0) {
      for (std::size_t i = 0; i < num_vertices; ++i) indices.push_back(i);
      return indices;
    }
    const Values values(file_, model_, primitive.indices, what + ": indices");
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
  tinygltf::Model model_;
  MeshBuilder builder_;
  std::int64_t num_faces_ = 0;
  std::int64_t num_other_ = 0;
};

}  // namespace

Mesh read_gltf(const std::filesystem::path& path) { return GltfReader(path).read(); }

}  // namespace patinate
