#include "app/output/surface_files.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "libcommon/controls/image_control.h"
#include "libcommon/image/filters.h"
#include "patinate/atlas/dilate.h"
#include "patinate/atlas/sheet.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::app {

namespace {

namespace fs = std::filesystem;

/// Color is the first.
constexpr std::array kFiles{
    SurfaceFiles::Named{"texture",
                        "Color of a mesh; with UDIM tiles or several materials one file each: tex.<UDIM>.png",
                        &SurfaceFiles::color},
    SurfaceFiles::Named{"normal-map", "Normals of a mesh in tangent space, as in glTF", &SurfaceFiles::normal},
    SurfaceFiles::Named{"roughness-map", "Roughness, [0, 1]", &SurfaceFiles::roughness},
    SurfaceFiles::Named{"metalness-map", "Metalness, [0, 1]", &SurfaceFiles::metalness},
    SurfaceFiles::Named{"specular-map", "Reflectance at normal incidence of nonmetals, linear",
                        &SurfaceFiles::specular},
    SurfaceFiles::Named{"height-map", "Relief in mm", &SurfaceFiles::height},
    SurfaceFiles::Named{"wetness-map", "Wetness, [0, 1]", &SurfaceFiles::wetness}};

ImageF read_normals(const fs::path& file) {
  ImageF normals = read_color(file, {.kind = Response::Kind::Linear});
  if (probe_image(file).is_integer) {
    for (float& n : normals.values()) n = 2.0f * n - 1.0f;
  }
  return normals;
}

ImageF read_linear(const fs::path& file) { return read_color(file, {.kind = Response::Kind::Linear}); }
ImageF read_scalar(const fs::path& file) { return read_gray(file); }
ImageF read_albedo(const fs::path& file) { return read_color(file); }

ImageF read_map(const AtlasMesh& atlas, const fs::path& file, ImageF (*read)(const fs::path&), Mesh& mesh_over_sheet) {
  if (file.empty()) return {};
  std::vector<ImageF> textures;
  for (const fs::path& tile : tile_map_files(file, atlas.tile_names())) textures.push_back(read(tile));
  return sheet_texture(atlas, std::move(textures), mesh_over_sheet);
}

}  // namespace

std::span<const SurfaceFiles::Named> SurfaceFiles::named() { return kFiles; }

bool SurfaceFiles::has_more() const {
  return std::any_of(kFiles.begin() + 1, kFiles.end(), [this](const Named& f) { return !(this->*f.file).empty(); });
}

void SurfaceFiles::add_to(ContentHash& hash, const AtlasMesh& atlas) const {
  for (const fs::path& file : tile_map_files(color, atlas.tile_names())) hash.add_file(file);
  for (const Named& f : named().subspan(1)) {
    if ((this->*f.file).empty()) continue;
    hash.add(f.name);
    for (const fs::path& file : tile_map_files(this->*f.file, atlas.tile_names())) hash.add_file(file);
  }
}

ImageF sheet_texture(const AtlasMesh& atlas, std::vector<ImageF> textures, Mesh& mesh_over_sheet) {
  if (atlas.tiles.size() == 1) {
    mesh_over_sheet = unit_square_mesh(atlas);
    dilate(textures.front(), TexelMap(mesh_over_sheet, textures.front().width(), textures.front().height()).coverage(),
           -1);
    return std::move(textures.front());
  }
  int side = 1;
  for (const ImageF& texture : textures) side = std::max({side, texture.width(), texture.height()});
  const Sheet sheet = make_sheet(atlas.tile_names(), side);
  mesh_over_sheet = sheet_mesh(atlas, sheet);
  const ImageU8 coverage = TexelMap(mesh_over_sheet, sheet).coverage();
  ImageF texture(sheet.width(), sheet.height(), textures.front().channels());
  for (int i = 0; i < sheet.num_tiles(); ++i) {
    ImageF tile = resize_bilinear(textures[textures.size() == 1 ? 0 : static_cast<std::size_t>(i)], side, side);
    dilate(tile, cut_tile(coverage, sheet, i), -1);
    paste_tile(texture, sheet, i, tile);
  }
  return texture;
}

ImageF read_color_map(const AtlasMesh& atlas, const SurfaceFiles& files, Mesh& mesh_over_sheet) {
  return read_map(atlas, files.color, read_albedo, mesh_over_sheet);
}

SurfaceMaps read_surface_maps(const AtlasMesh& atlas, const SurfaceFiles& files, double mm_per_unit,
                              Mesh& mesh_over_sheet) {
  const auto read = [&](const fs::path& file, ImageF (*how)(const fs::path&)) {
    return read_map(atlas, file, how, mesh_over_sheet);
  };
  SurfaceMaps maps{.color = read(files.color, read_albedo),
                   .normals = read(files.normal, read_normals),
                   .roughness = read(files.roughness, read_scalar),
                   .metalness = read(files.metalness, read_scalar),
                   .specular = read(files.specular, read_linear),
                   .height = read(files.height, read_scalar),
                   .wetness = read(files.wetness, read_scalar)};
  for (float& h : maps.height.values()) h = static_cast<float>(static_cast<double>(h) / mm_per_unit);
  return maps;
}

}  // namespace patinate::app
