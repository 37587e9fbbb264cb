#include "simulation/composition/base_layer.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "libcommon/core/parallel.h"
#include "simulation/composition/grain.h"
#include "simulation/composition/laid_picture.h"
#include "simulation/rules/scene_maps.h"

namespace patinate::simulation::composition {

namespace {

constexpr std::int32_t kNoHeights[kTile] = {};
constexpr std::size_t kFirstGrain = kMaxMaterials;  ///< First noise of objects: other noise than that of materials.

/// Bilinear, ends repeated; 0 where the map is not finite. @param x,y  In pixels, centers at integers.
double sample_map(const ImageF& map, double x, double y, int channel) {
  const double cx = std::clamp(x, 0.0, map.width() - 1.0), cy = std::clamp(y, 0.0, map.height() - 1.0);
  const int x0 = static_cast<int>(cx), y0 = static_cast<int>(cy);
  const int x1 = std::min(x0 + 1, map.width() - 1), y1 = std::min(y0 + 1, map.height() - 1);
  const double fx = cx - x0, fy = cy - y0;
  const auto at = [&](int px, int py) {
    return static_cast<double>(map.at(px, py, std::min(channel, map.channels() - 1)));
  };
  const double value =
      (1.0 - fy) * ((1.0 - fx) * at(x0, y0) + fx * at(x1, y0)) + fy * ((1.0 - fx) * at(x0, y1) + fx * at(x1, y1));
  return std::isfinite(value) ? value : 0.0;
}

/// Where a texel of the atlas lies in the maps of an object.
struct MapPlace {
  double u = 0.0;  ///< From the left of the object's square, [0, 1].
  double v = 0.0;  ///< From its top.

  [[nodiscard]] double sample(const ImageF& map, int channel) const {
    return sample_map(map, u * map.width() - 0.5, v * map.height() - 0.5, channel);
  }
};

MapPlace place_of(const TileGrid& grid, const std::array<double, 3>& square, int x, int y) {
  const double top = 1.0 - square[1] - square[2];
  return {.u = ((x + 0.5) - square[0] * grid.width) / (square[2] * grid.width),
          .v = ((y + 0.5) - top * grid.height) / (square[2] * grid.height)};
}

std::uint32_t specular_code(double specular) {
  return static_cast<std::uint32_t>(
      std::lround(255.0 * std::clamp(std::isfinite(specular) ? specular : 0.0, 0.0, 1.0)));
}

std::uint32_t packed(const std::array<std::uint8_t, 3>& rgb, std::uint32_t specular) {
  return rgb[0] | std::uint32_t{rgb[1]} << 8 | std::uint32_t{rgb[2]} << 16 | specular << 24;
}

bool has_pattern(const SceneObject& object) {
  return object.preset.second_color.has_value() && object.preset.color.image.empty();
}

bool has_grain(const SceneObject& object) {
  return has_pattern(object) && object.preset.pattern.empty() && object.color_map.empty();
}

bool has_color_map(const SceneObject& object) {
  return !object.color_map.empty() || !object.specular_map.empty() || !object.preset.color.image.empty() ||
         has_pattern(object);
}

/// A picture with a width in mm, and no map over it.
bool has_laid_picture(const SceneObject& object) {
  return object.color_map.empty() && !object.preset.color.image.empty() && object.preset.color.image_mm > 0.0;
}

/// Every map that is the pattern of an object, once.
std::vector<std::string> pattern_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) {
    if (has_pattern(object) && !object.preset.pattern.empty() &&
        std::find(names.begin(), names.end(), object.preset.pattern) == names.end())
      names.push_back(object.preset.pattern);
  }
  return names;
}

/// Code of a texel of an object with a map. @param laid  Its preset's picture there, if that has a width in mm.
/// @param pattern  Of it, [0, 1].
std::uint32_t code_of(const SceneObject& object, const MapPlace& place, int x, int y, const std::optional<Vec3>& laid,
                      double pattern) {
  Vec3 color = object.preset.color.color;
  if (!object.color_map.empty()) {
    for (int c = 0; c < 3; ++c) color[c] = place.sample(object.color_map, c);
  } else if (laid) {
    color = *laid;
  } else if (const ImageF& picture = object.preset.color.image; !picture.empty()) {
    for (int c = 0; c < 3; ++c)
      color[c] = static_cast<double>(
          picture.at(x % picture.width(), y % picture.height(), std::min(c, picture.channels() - 1)));
  }
  if (object.color_map.empty() && has_pattern(object)) color += pattern * (*object.preset.second_color - color);
  return packed(srgb8_of(color), specular_code(object.specular_map.empty() ? object.preset.specular
                                                                           : place.sample(object.specular_map, 0)));
}

}  // namespace

void unpack(std::uint32_t code, std::size_t l, BaseTile& tile) {
  tile.code[l] = code;
  for (unsigned c = 0; c < 3; ++c) tile.linear[c][l] = linear16_of_srgb8()[code >> (8 * c) & 255];
  tile.specular[l] = static_cast<std::int32_t>(((code >> 24) * kOne + 127) / 255);
}

struct BaseLayer::ObjectColors {
  const SurfaceParameter* pattern = nullptr;  ///< Null: none.
  std::optional<LaidPicture> picture = {};    ///< With a width in mm.
  const TexelPlaces* places = nullptr;        ///< Where there is a picture.
  Grain* grain = nullptr;                     ///< In place of a pattern: of kFirstGrain and the object.

  [[nodiscard]] double pattern_at(std::size_t object, TexelIndex t) const {
    if (grain != nullptr)
      return grain->tile(kFirstGrain + object, TileGrid::tile_of(t))[t % TileGrid::kTileTexels] / 255.0;
    return pattern == nullptr ? 0.0 : parameter_at(*pattern, t);
  }
};

BaseLayer::BaseLayer(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, double quanta_per_mm,
                     const RunControl& control)
    : surface_(&surface),
      tile_object_(surface.grid().num_tiles(), kNone),
      plain_(scene.objects.size()),
      codes_(surface.grid().num_pages()),
      heights_(surface.grid().num_pages()) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Preset& preset = scene.objects[i].preset;
    const std::uint32_t code = packed(srgb8_of(preset.color.color), specular_code(preset.specular));
    for (std::size_t l = 0; l < kTile; ++l) unpack(code, l, plain_[i]);
    has_heights_ = has_heights_ || !scene.objects[i].height_map.empty();
  }
  const std::vector<std::string> names = pattern_names(scene);
  const std::vector<SurfaceParameter> patterns =
      make_parameters(names, scene, scene_mesh, surface, control.part(0.0, 0.5));
  std::vector<ObjectColors> colors(scene.objects.size());
  const bool has_laid = std::any_of(scene.objects.begin(), scene.objects.end(), has_laid_picture);
  const bool is_grained = std::any_of(scene.objects.begin(), scene.objects.end(), has_grain);
  const std::optional<TexelPlaces> places =
      has_laid || is_grained ? std::optional<TexelPlaces>(std::in_place, scene_mesh, surface) : std::nullopt;
  std::optional<Grain> grain;
  if (is_grained) {
    std::vector<double> lengths(kFirstGrain, 0.0);
    for (const SceneObject& object : scene.objects) lengths.push_back(has_grain(object) ? object.preset.grain_mm : 0.0);
    grain.emplace(*places).set_lengths(lengths);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const auto found = std::find(names.begin(), names.end(), object.preset.pattern);
    if (found != names.end()) colors[i].pattern = &patterns[found - names.begin()];
    if (has_grain(object)) colors[i].grain = &*grain;
    if (!has_laid_picture(object)) continue;
    colors[i].picture.emplace(object.preset.color, surface.median_texel_size_mm());
    colors[i].places = &*places;
  }
  parallel_for(surface.grid().num_pages(), 4, control.part(0.5, 1.0), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t page = begin; page < end; ++page)
      fill_page(static_cast<std::uint32_t>(page), scene, scene_mesh, colors, quanta_per_mm);
  });
}

void BaseLayer::fill_page(std::uint32_t page, const Scene& scene, const SceneMesh& scene_mesh,
                          const std::vector<ObjectColors>& colors, double quanta_per_mm) {
  const TileGrid& grid = surface_->grid();
  for (std::uint32_t i = 0; i < TileGrid::kPageTexels; ++i) {
    const TexelIndex t = page * TileGrid::kPageTexels + i;
    if (!surface_->is_covered(t)) continue;
    const auto object = static_cast<std::uint16_t>(surface_->object(surface_->triangle(t)));
    std::uint16_t& of_tile = tile_object_[TileGrid::tile_of(t)];
    of_tile = of_tile == kNone || of_tile == object ? object : kSeveral;
    const SceneObject& from = scene.objects[object];
    if (!has_color_map(from) && from.height_map.empty()) continue;
    const int x = grid.x(t), y = grid.y(t);
    const MapPlace place = place_of(grid, scene_mesh.uv_squares[object], x, y);
    if (has_color_map(from)) {
      if (!codes_[page]) codes_[page] = std::make_unique<std::uint32_t[]>(TileGrid::kPageTexels);
      const ObjectColors& of = colors[object];
      codes_[page][i] = code_of(
          from, place, x, y,
          of.picture ? std::optional(of.picture->color(of.places->point(t), of.places->normal(t))) : std::nullopt,
          of.pattern_at(object, t));
    }
    if (!from.height_map.empty()) {
      if (!heights_[page]) heights_[page] = std::make_unique<std::int32_t[]>(TileGrid::kPageTexels);
      heights_[page][i] = static_cast<std::int32_t>(
          std::lround(std::clamp<double>(place.sample(from.height_map, 0) * quanta_per_mm, -kMaxHeight, kMaxHeight)));
    }
  }
  if (!codes_[page]) return;
  for (std::uint32_t i = 0; i < TileGrid::kPageTexels; ++i) {  // objects without maps that share the page
    const int triangle = surface_->triangle(page * TileGrid::kPageTexels + i);
    if (triangle < 0) continue;
    const auto object = static_cast<std::size_t>(surface_->object(triangle));
    if (!has_color_map(scene.objects[object])) codes_[page][i] = plain_[object].code[0];
  }
}

std::size_t BaseLayer::memory() const {
  std::size_t pages = 0;
  for (const auto& page : codes_) pages += page ? 1 : 0;
  for (const auto& page : heights_) pages += page ? 1 : 0;
  return pages * TileGrid::kPageTexels * 4 + tile_object_.size() * 2;
}

const BaseTile& BaseLayer::tile(TileIndex tile, BaseTile& buffer) const {
  const std::uint32_t* page = codes_[tile / TileGrid::kPageTiles].get();
  if (page == nullptr && tile_object_[tile] < plain_.size()) return plain_[tile_object_[tile]];
  for (std::uint32_t l = 0; l < kTile; ++l) {
    std::uint32_t code = 0;
    if (page != nullptr) {
      code = page[tile % TileGrid::kPageTiles * kTile + l];
    } else if (const int triangle = surface_->triangle(tile * kTile + l); triangle >= 0) {
      code = plain_[surface_->object(triangle)].code[0];
    }
    unpack(code, l, buffer);
  }
  return buffer;
}

const std::int32_t* BaseLayer::heights(TileIndex tile) const {
  const std::int32_t* page = heights_[tile / TileGrid::kPageTiles].get();
  return page == nullptr ? kNoHeights : page + tile % TileGrid::kPageTiles * kTile;
}

}  // namespace patinate::simulation::composition
