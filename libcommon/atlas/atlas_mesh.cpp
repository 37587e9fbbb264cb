#include "patinate/atlas/atlas_mesh.h"

#include <unordered_map>
#include <utility>

#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Gives every triangle UVs map(tile, uv). A UV that two tiles use becomes two.
template <class Map>
void map_uvs(Mesh& mesh, const std::vector<int>& triangle_tile, std::size_t num_tiles, Map&& map) {
  if (num_tiles == 1) {
    for (Vec2& uv : mesh.uvs) uv = map(0, uv);
    return;
  }
  std::vector<Vec2> uvs;
  std::unordered_map<std::uint64_t, int> index_of;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int tile = triangle_tile[t];
    for (int& corner : mesh.uv_triangles[t]) {
      const std::uint64_t key = static_cast<std::uint64_t>(tile) << 32 | static_cast<std::uint64_t>(corner);
      const auto [found, is_new] = index_of.try_emplace(key, static_cast<int>(uvs.size()));
      if (is_new) uvs.push_back(map(static_cast<std::size_t>(tile), mesh.uvs[corner]));
      corner = found->second;
    }
  }
  mesh.uvs = std::move(uvs);
}

}  // namespace

AtlasMesh atlas_mesh_of(Mesh mesh, UvLayout layout) {
  AtlasMesh atlas;
  atlas.rule = layout.rule;
  atlas.triangle_tile = std::move(layout.triangle_tile);
  bool moves = false;
  for (const AtlasTile& tile : layout.tiles) moves = moves || tile.shift != tile.origin || tile.scale != 1.0;
  const bool is_udim = layout.rule == UvLayoutRule::Udim;
  if (moves || is_udim) {
    map_uvs(mesh, atlas.triangle_tile, layout.tiles.size(), [&](std::size_t i, const Vec2& uv) -> Vec2 {
      const AtlasTile& tile = layout.tiles[i];
      if (!is_udim) return (uv - tile.shift) * tile.scale + tile.origin;
      return uv.cwiseMax(tile.origin).cwiseMin(Vec2(tile.origin + Vec2::Ones()));  // Rounding may have left the tile.
    });
  }
  for (AtlasTile& tile : layout.tiles) tile.shift = tile.origin, tile.scale = 1.0;
  atlas.tiles = std::move(layout.tiles);
  atlas.mesh = std::move(mesh);
  return atlas;
}

std::vector<std::string> AtlasMesh::tile_names() const {
  std::vector<std::string> names;
  for (const AtlasTile& tile : tiles) names.push_back(tile.name);
  return names;
}

AtlasMesh read_back_atlas_mesh(Mesh mesh, UvLayoutRule rule, const std::vector<std::string>& names) {
  if (!mesh.has_uvs()) throw InvalidInput("the mesh has no UVs");
  UvLayout layout = uv_layout_by_rule(mesh, rule);
  AtlasMesh atlas = atlas_mesh_of(std::move(mesh), std::move(layout));
  if (atlas.tile_names() != names) throw InvalidInput("the mesh does not have the tiles that the atlas was made with");
  return atlas;
}

Mesh sheet_mesh(const AtlasMesh& atlas, const Sheet& sheet) {
  if (sheet.names.size() != atlas.tiles.size())
    throw InvalidInput("the sheet has another number of tiles than the mesh");
  Mesh mesh = atlas.mesh;
  if (atlas.tiles.size() == 1 && atlas.tiles[0].origin == Vec2::Zero()) return mesh;
  map_uvs(mesh, atlas.triangle_tile, atlas.tiles.size(), [&](std::size_t i, const Vec2& uv) -> Vec2 {
    return sheet.sheet_uv(static_cast<int>(i), uv - atlas.tiles[i].origin);
  });
  return mesh;
}

Mesh unit_square_mesh(const AtlasMesh& atlas) {
  Mesh mesh = atlas.mesh;
  map_uvs(mesh, atlas.triangle_tile, atlas.tiles.size(),
          [&](std::size_t i, const Vec2& uv) -> Vec2 { return uv - atlas.tiles[i].origin; });
  return mesh;
}

TexelMap make_texel_map(const AtlasMesh& atlas, int resolution, const RunControl& control) {
  const Sheet sheet = make_sheet(atlas.tile_names(), resolution);
  return TexelMap(sheet_mesh(atlas, sheet), sheet, control);
}

}  // namespace patinate
