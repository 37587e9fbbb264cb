#include "patinate/output/obj.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/mesh_files/mesh_formats.h"
#include "libcommon/output/materialx.h"
#include "libcommon/output/model_textures.h"
#include "patinate/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

void check_obj(const Mesh& mesh, const GlbTiles& tiles, const GlbAppearance& look) {
  if (!mesh.has_uvs()) throw InvalidInput("obj: the mesh has no UVs");
  const std::size_t n = tiles.names.size();
  if (n > 1 && tiles.triangle_tile.size() != mesh.triangles.size())
    throw InvalidInput("obj: there is not a tile for every triangle");
  const auto is_whole = [n](std::size_t size) { return size == 0 || size == n; };
  if (look.base_colors.size() != n || !is_whole(look.normals.size()) || !is_whole(look.speculars.size()) ||
      !is_whole(look.metalness.size()) || !is_whole(look.reflectance_colors.size()) || !is_whole(look.heights.size()))
    throw InvalidInput("obj: expected a texture for every tile");
}

/// Triangles by object, then by tile; surfaces name both.
Mesh grouped(const Mesh& mesh, const GlbTiles& tiles, const ObjOptions& options) {
  const auto object_of = [&](std::size_t t) {
    return options.objects.triangle_object.empty() ? 0 : options.objects.triangle_object[t];
  };
  const auto tile_of = [&](std::size_t t) { return tiles.triangle_tile.empty() ? 0 : tiles.triangle_tile[t]; };
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(object_of(a), tile_of(a)) < std::pair(object_of(b), tile_of(b));
  });
  Mesh out = mesh;
  out.surfaces.clear();
  std::map<std::pair<int, int>, int> surface_of;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t t = order[k];
    out.triangles[k] = mesh.triangles[t];
    out.uv_triangles[k] = mesh.uv_triangles[t];
    if (!mesh.normal_triangles.empty()) out.normal_triangles[k] = mesh.normal_triangles[t];
    const auto [at, is_new] = surface_of.try_emplace({object_of(t), tile_of(t)}, static_cast<int>(out.surfaces.size()));
    if (is_new) {
      out.surfaces.push_back({options.objects.names.empty() ? options.name : options.objects.names[object_of(t)],
                              tile_material(tiles.names[tile_of(t)])});
    }
    out.triangle_surface.resize(order.size());
    out.triangle_surface[k] = at->second;
  }
  return out;
}

/// The dialect with physical terms that Blender, Maya and others read ("PBR extension": Pr, Pm, norm).
std::string mtl_text(const GlbTiles& tiles, const TextureFiles& files, const ObjOptions& options) {
  std::string out = "# patinate" + (options.key.empty() ? "" : " " + options.key) + "\n";
  for (const std::string& credit : options.credits) out += "# " + credit + "\n";
  for (std::size_t tile = 0; tile < tiles.names.size(); ++tile) {
    const auto map = [&](const std::string& statement, const TextureFiles::Series& series) {
      if (!series.empty()) out += statement + " " + series.front()[tile] + "\n";
    };
    out += "newmtl " + tile_material(tiles.names[tile]) + "\nKa 0 0 0\nKd 1 1 1\nKs 0.04 0.04 0.04\nillum 2\n";
    map("map_Kd", files.base_colors);
    if (files.roughness.empty()) out += "Pr " + number_text(options.roughness) + "\n";
    map("map_Pr", files.roughness);
    if (files.metalness.empty()) out += "Pm 0\n";
    map("map_Pm", files.metalness);
    if (const double f0 = files.reflectances.front(); f0 != 0.04)
      out += "Ni " + number_text(rounded(index_of_refraction(f0), 9)) + "\n";
    map("norm", files.normals);
    map("disp", files.heights);
  }
  return out + "# end\n";
}

}  // namespace

void write_obj_model(const fs::path& path, const Mesh& mesh, const GlbTiles& tiles, const GlbAppearance& appearance,
                     const ObjOptions& options, const RunControl& control) {
  check_obj(mesh, tiles, appearance);
  const std::string stem = path.stem().string(), textures = stem + ".obj.textures";
  WorkFolder work(folder_of(path) / ("." + stem + ".obj.partial"));
  TextureFiles files;
  write_textures(work.path(), textures + "/", 0, appearance, options.key, files);
  control.report(0.8);
  control.throw_if_stopped();
  work.keep_as(folder_of(path) / textures);
  write_atomically(fs::path(path).replace_extension(".mtl"), mtl_text(tiles, files, options));
  write_atomically(fs::path(path).replace_extension(".obj.mtlx"), materialx_text(tiles.names, files,
                                                                                 {.time_names = {appearance.name},
                                                                                  .roughness = options.roughness,
                                                                                  .key = options.key,
                                                                                  .credits = options.credits}));
  write_obj(path, grouped(mesh, tiles, options), options.key, stem + ".mtl");
  control.report(1.0);
}

}  // namespace patinate
