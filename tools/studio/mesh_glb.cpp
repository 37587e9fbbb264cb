#include "tools/studio/mesh_glb.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::studio {

namespace {

constexpr int kFloat = 5126, kUint32 = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;

void append_u32(std::string& bytes, std::size_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((value >> shift) & 0xFF);
}

class Glb {
 public:
  template <class T>
  int add(const std::vector<T>& values, int components, const char* type, int component_type, int target) {
    json_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * sizeof(T)}, {"target", target}});
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                  {"componentType", component_type},
                                  {"count", values.size() / static_cast<std::size_t>(components)},
                                  {"type", type}});
    return static_cast<int>(json_["accessors"].size()) - 1;
  }
  [[nodiscard]] Json& json() { return json_; }
  [[nodiscard]] std::string text() {
    json_["asset"] = {{"version", "2.0"}, {"generator", "patinate"}};
    json_["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
    std::string json = json_.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string out = "glTF";
    append_u32(out, 2);
    append_u32(out, 12 + 8 + json.size() + 8 + bytes_.size());
    append_u32(out, json.size());
    out += "JSON" + json;
    append_u32(out, bytes_.size());
    return out + std::string("BIN\0", 4) + bytes_;
  }

 private:
  Json json_ = Json::object();
  std::string bytes_;  ///< All values have four bytes, so everything is aligned.
};

struct Vertices {
  std::vector<float> positions, normals, uvs;
  std::vector<std::uint32_t> indices;
};

Vertices vertices_of(const Mesh& mesh, const std::vector<int>& triangles, double scale, bool has_uvs) {
  Vertices out;
  std::map<std::array<int, 3>, std::uint32_t> index_of;
  for (const int t : triangles) {
    const auto i = static_cast<std::size_t>(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<int, 3> corner{mesh.triangles[i][k], has_uvs ? mesh.uv_triangles[i][k] : 0,
                                      mesh.normal_triangles[i][k]};
      const auto [found, is_new] = index_of.try_emplace(corner, static_cast<std::uint32_t>(index_of.size()));
      out.indices.push_back(found->second);
      if (!is_new) continue;
      const Vec3 p = scale * mesh.positions[static_cast<std::size_t>(corner[0])];
      const Vec3 n = mesh.normals[static_cast<std::size_t>(corner[2])].normalized();
      if (!p.allFinite() || !n.allFinite()) throw InvalidInput("the mesh has a value that is not finite");
      for (int c = 0; c < 3; ++c) out.positions.push_back(static_cast<float>(p[c]));
      for (int c = 0; c < 3; ++c) out.normals.push_back(static_cast<float>(n[c]));
      if (!has_uvs) continue;
      const Vec2& uv = mesh.uvs[static_cast<std::size_t>(corner[1])];
      out.uvs.push_back(static_cast<float>(uv.x()));
      out.uvs.push_back(static_cast<float>(1.0 - uv.y()));
    }
  }
  return out;
}

std::vector<float> floats_of(const std::vector<Vec3>& points, double scale) {
  std::vector<float> floats;
  for (const Vec3& p : points) {
    for (const double x : p) floats.push_back(static_cast<float>(scale * x));
  }
  return floats;
}

void set_bounds(Json& accessor, const std::vector<float>& positions) {
  std::array<float, 3> low{positions[0], positions[1], positions[2]}, high = low;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  accessor["min"] = low;
  accessor["max"] = high;
}

void add_part(Glb& glb, const Mesh& mesh, const MeshPart& part, double meters_per_unit, bool has_uvs) {
  const Vertices v = vertices_of(mesh, part.triangles, meters_per_unit, has_uvs);
  Json node{{"name", part.name}};
  if (!v.indices.empty()) {
    Json attributes{{"POSITION", glb.add(v.positions, 3, "VEC3", kFloat, kArrayBuffer)}};
    set_bounds(glb.json()["accessors"].back(), v.positions);
    attributes["NORMAL"] = glb.add(v.normals, 3, "VEC3", kFloat, kArrayBuffer);
    if (has_uvs) attributes["TEXCOORD_0"] = glb.add(v.uvs, 2, "VEC2", kFloat, kArrayBuffer);
    const int indices = glb.add(v.indices, 1, "SCALAR", kUint32, kElementBuffer);
    glb.json()["meshes"].push_back(
        {{"name", part.name}, {"primitives", Json::array({{{"attributes", attributes}, {"indices", indices}}})}});
    node["mesh"] = glb.json()["meshes"].size() - 1;
  } else if (!part.points.empty()) {
    constexpr int kPoints = 0;
    const std::vector<float> positions = floats_of(part.points, meters_per_unit);
    const Json attributes{{"POSITION", glb.add(positions, 3, "VEC3", kFloat, kArrayBuffer)}};
    set_bounds(glb.json()["accessors"].back(), positions);
    glb.json()["meshes"].push_back(
        {{"name", part.name}, {"primitives", Json::array({{{"attributes", attributes}, {"mode", kPoints}}})}});
    node["mesh"] = glb.json()["meshes"].size() - 1;
  }
  glb.json()["nodes"].push_back(std::move(node));
}

}  // namespace

std::string mesh_glb(const Mesh& mesh, const std::vector<MeshPart>& parts, double meters_per_unit) {
  Glb glb;
  const bool has_uvs = mesh.has_uvs();
  Json nodes = Json::array();
  for (const MeshPart& part : parts) {
    add_part(glb, mesh, part, meters_per_unit, has_uvs);
    nodes.push_back(nodes.size());
  }
  glb.json()["scenes"] = Json::array({{{"nodes", nodes}}});
  glb.json()["scene"] = 0;
  return glb.text();
}

std::string mesh_glb(const Mesh& mesh, const std::string& name, double meters_per_unit) {
  MeshPart part{.name = name, .triangles = std::vector<int>(mesh.triangles.size()), .points = {}};
  std::iota(part.triangles.begin(), part.triangles.end(), 0);
  return mesh_glb(mesh, {part}, meters_per_unit);
}

std::string scene_glb(const simulation::Scene& scene) {
  const simulation::SceneMesh all = simulation::make_scene_mesh(scene);
  std::vector<MeshPart> parts;
  for (const simulation::SceneObject& object : scene.objects) parts.push_back({object.name, {}, {}});
  for (std::size_t t = 0; t < all.object.size(); ++t) parts[all.object[t]].triangles.push_back(static_cast<int>(t));
  return mesh_glb(all.mesh, parts, 0.001);
}

}  // namespace patinate::studio
