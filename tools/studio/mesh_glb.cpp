#include "tools/studio/mesh_glb.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "libcommon/output/glb_document.h"
#include "libcommon/output/relief.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/simulation/surface_atlas.h"

namespace patinate::studio {

namespace {

constexpr int kMaxReliefTriangles = 300'000;  ///< What a browser without a graphics card can still turn.

class Glb {
 public:
  int add_floats(const std::vector<float>& values, std::size_t components, const char* shape) {
    return add_gltf_accessor(json_, add(values, kGltfVertices), kGltfFloat, values.size() / components, shape);
  }
  int add_positions(const std::vector<float>& values) {
    return add_gltf_positions(json_, add(values, kGltfVertices), values);
  }
  int add_indices(const std::vector<std::uint32_t>& values) {
    return add_gltf_accessor(json_, add(values, kGltfIndices), kGltfUint32, values.size(), "SCALAR");
  }
  [[nodiscard]] Json& json() { return json_; }
  [[nodiscard]] std::string text() { return glb_head(json_, bytes_.views(), bytes_.size(), "glb") + bytes_.padded(); }

 private:
  template <class T>
  int add(const std::vector<T>& values, int target) {
    (void)json_["bufferViews"];  // They stand before the accessors.
    return bytes_.add(values, target);
  }

  Json json_ = Json::object();
  GlbBytes bytes_;
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
      const Vec3 p = scale * mesh.positions[corner[0]];
      const Vec3 n = mesh.normals[corner[2]].normalized();
      if (!p.allFinite() || !n.allFinite()) throw InvalidInput("the mesh has a value that is not finite");
      for (int c = 0; c < 3; ++c) out.positions.push_back(static_cast<float>(p[c]));
      for (int c = 0; c < 3; ++c) out.normals.push_back(static_cast<float>(n[c]));
      if (!has_uvs) continue;
      const Vec2& uv = mesh.uvs[corner[1]];
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

void add_part(Glb& glb, const Mesh& mesh, const MeshPart& part, double meters_per_unit, bool has_uvs) {
  const Vertices v = vertices_of(mesh, part.triangles, meters_per_unit, has_uvs);
  Json node{{"name", part.name}};
  if (!v.indices.empty()) {
    Json attributes{{"POSITION", glb.add_positions(v.positions)}};
    attributes["NORMAL"] = glb.add_floats(v.normals, 3, "VEC3");
    if (has_uvs) attributes["TEXCOORD_0"] = glb.add_floats(v.uvs, 2, "VEC2");
    const int indices = glb.add_indices(v.indices);
    glb.json()["meshes"].push_back(
        {{"name", part.name}, {"primitives", Json::array({{{"attributes", attributes}, {"indices", indices}}})}});
    node["mesh"] = glb.json()["meshes"].size() - 1;
  } else if (!part.points.empty()) {
    constexpr int kPoints = 0;
    const std::vector<float> positions = floats_of(part.points, meters_per_unit);
    const Json attributes{{"POSITION", glb.add_positions(positions)}};
    glb.json()["meshes"].push_back(
        {{"name", part.name}, {"primitives", Json::array({{{"attributes", attributes}, {"mode", kPoints}}})}});
    node["mesh"] = glb.json()["meshes"].size() - 1;
  }
  glb.json()["nodes"].push_back(std::move(node));
}

}  // namespace

PartedMesh parted_mesh(Mesh mesh, const std::string& name) {
  MeshPart part{.name = name, .triangles = std::vector<int>(mesh.triangles.size()), .points = {}};
  std::iota(part.triangles.begin(), part.triangles.end(), 0);
  return {.mesh = std::move(mesh), .parts = {std::move(part)}};
}

PartedMesh parted_mesh(const simulation::Scene& scene) {
  simulation::SceneMesh all = simulation::make_scene_mesh(scene);
  PartedMesh out{.mesh = std::move(all.mesh), .parts = {}};
  for (const simulation::SceneObject& object : scene.objects) out.parts.push_back({object.name, {}, {}});
  for (std::size_t t = 0; t < all.object.size(); ++t) out.parts[all.object[t]].triangles.push_back(static_cast<int>(t));
  return out;
}

PartedMesh cut_to_texels(PartedMesh given, int texels) {
  if (!given.mesh.has_uvs()) return given;
  PartedMesh out{.mesh = std::move(given.mesh), .parts = std::move(given.parts)};
  // Refined triangles keep the surface of the one that they are cut from: here, its part.
  const auto num_parts = static_cast<int>(out.parts.size());
  out.mesh.triangle_surface.assign(out.mesh.triangles.size(), num_parts);
  for (int p = 0; p < num_parts; ++p) {
    for (const int t : out.parts[static_cast<std::size_t>(p)].triangles)
      out.mesh.triangle_surface[static_cast<std::size_t>(t)] = p;
  }
  Mesh ready = with_shared_positions(with_normals(std::move(out.mesh)));
  std::vector<float> none(ready.positions.size(), 0.0f);
  out.mesh = refined_to_texels(std::move(ready), ImageF(texels, texels), kMaxReliefTriangles, none);
  for (MeshPart& part : out.parts) part.triangles.clear();
  for (std::size_t t = 0; t < out.mesh.triangles.size(); ++t) {
    if (const int p = out.mesh.triangle_surface[t]; p < num_parts)
      out.parts[static_cast<std::size_t>(p)].triangles.push_back(static_cast<int>(t));
  }
  return out;
}

std::string mesh_glb(const PartedMesh& mesh, double meters_per_unit) {
  Glb glb;
  const bool has_uvs = mesh.mesh.has_uvs();
  Json nodes = Json::array();
  for (const MeshPart& part : mesh.parts) {
    add_part(glb, mesh.mesh, part, meters_per_unit, has_uvs);
    nodes.push_back(nodes.size());
  }
  glb.json()["scenes"] = Json::array({{{"nodes", nodes}}});
  glb.json()["scene"] = 0;
  return glb.text();
}

}  // namespace patinate::studio
