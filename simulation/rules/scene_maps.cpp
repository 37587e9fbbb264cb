#include "simulation/rules/scene_maps.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/error.h"
#include "simulation/rules/boards.h"

namespace patinate::simulation {

namespace {

Vec3 up_of(const Scene& scene) {
  const double gravity = scene.gravity_mm_s2.norm();
  if (!(gravity > 0.0)) return Vec3::UnitY();
  return Vec3(-scene.gravity_mm_s2 / gravity) + Vec3::Zero();  // no -0
}

/// A value for every covered texel. @param values  values(tile, out): out[i] of those of a tile that are covered.
template <class Values>
SurfaceParameter coded_by_tile(std::string name, const SurfaceAtlas& surface, const RunControl& control,
                               Values&& values) {
  constexpr std::uint32_t kTile = TileGrid::kTileTexels;
  std::vector<std::uint16_t> codes(surface.grid().num_texels());
  parallel_for(std::int64_t{surface.grid().num_tiles()}, 256, control, [&](std::int64_t begin, std::int64_t end) {
    std::array<double, kTile> of_tile;
    for (auto tile = static_cast<TileIndex>(begin); tile < static_cast<TileIndex>(end); ++tile) {
      values(tile, of_tile);
      for (std::uint32_t i = 0; i < kTile; ++i) {
        if (!surface.is_covered(tile * kTile + i)) continue;
        codes[tile * kTile + i] =
            static_cast<std::uint16_t>(std::floor(std::clamp(of_tile[i], 0.0, 1.0) * 65535.0 + 0.5));
      }
    }
  });
  return {.name = std::move(name), .values = std::move(codes)};
}

/// Map of a function. @param value  Of (texel, object).
template <class Value>
SurfaceParameter coded(std::string name, const SurfaceAtlas& surface, const RunControl& control, Value&& value) {
  return coded_by_tile(std::move(name), surface, control,
                       [&](TileIndex tile, std::array<double, TileGrid::kTileTexels>& out) {
                         for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
                           const TexelIndex t = tile * TileGrid::kTileTexels + i;
                           if (surface.is_covered(t))
                             out[i] = value(t, static_cast<std::size_t>(surface.object(surface.triangle(t))));
                         }
                       });
}

/// Pictures of objects, each over its own UVs.
SurfaceParameter image_parameter(const SceneMap& map, const Scene& scene, const SceneMesh& scene_mesh,
                                 const SurfaceAtlas& surface, const RunControl& control) {
  struct Laid {
    ImageF image;
    int x = 0, y = 0;
  };
  std::vector<Laid> laid(scene.objects.size());
  for (std::size_t i = 0; i < laid.size() && i < map.images.size(); ++i) {
    if (map.images[i].empty()) continue;
    const auto [u, v, side] = scene_mesh.uv_squares[i];
    const auto texels = [&](double share) { return static_cast<int>(std::lround(share * scene.resolution)); };
    laid[i] = {.image = resize_bilinear(map.images[i], texels(side), texels(side)),
               .x = texels(u),
               .y = texels(1.0 - v - side)};
  }
  const TileGrid& grid = surface.grid();
  return coded(map.name, surface, control, [&](TexelIndex t, std::size_t object) {
    const Laid& of = laid[object];
    if (of.image.empty()) return 0.0;
    return static_cast<double>(of.image.at(std::clamp(grid.x(t) - of.x, 0, of.image.width() - 1),
                                           std::clamp(grid.y(t) - of.y, 0, of.image.height() - 1)));
  });
}

/// A number of its own for each name, so that objects of one mesh do not look alike.
std::int64_t seed_of(const std::string& name, std::int64_t seed) {
  std::uint64_t hash = 0xCBF29CE484222325u;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return static_cast<std::int64_t>((hash ^ static_cast<std::uint64_t>(seed)) >> 1);
}

/// Places of a tile, by object, at which noise is asked for at once.
struct NoisePlaces {
  std::array<Vec3, TileGrid::kTileTexels> position;
  std::array<std::uint32_t, TileGrid::kTileTexels> texel;  ///< In the tile.
  std::array<double, TileGrid::kTileTexels> noise;
  std::size_t size = 0;
};

SurfaceParameter noise_parameter(std::string name, const NoiseOptions& noise, const Scene& scene,
                                 const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const RunControl& control) {
  std::vector<NoiseOptions> options(scene.objects.size(), noise);
  for (std::size_t i = 0; i < options.size(); ++i) options[i].seed = seed_of(scene.objects[i].name, noise.seed);
  const TileGrid& grid = surface.grid();
  const TexelMap map(in_own_places(scene, scene_mesh).mesh, grid.width, grid.height, control);
  const double least_mm = 2.0 * surface.median_texel_size_mm();
  return coded_by_tile(std::move(name), surface, control,
                       [&](TileIndex tile, std::array<double, TileGrid::kTileTexels>& out) {
                         NoisePlaces places;
                         std::size_t object = 0;
                         const auto take = [&] {
                           noise_at(std::span(places.position).first(places.size), options[object], least_mm,
                                    std::span(places.noise).first(places.size));
                           for (std::size_t k = 0; k < places.size; ++k) out[places.texel[k]] = places.noise[k];
                           places.size = 0;
                         };
                         for (std::uint32_t i = 0; i < TileGrid::kTileTexels; ++i) {
                           const TexelIndex t = tile * TileGrid::kTileTexels + i;
                           if (!surface.is_covered(t)) continue;
                           const TexelId texel = TexelId{grid.y(t)} * grid.width + grid.x(t);
                           out[i] = 0.5;
                           if (!map.is_covered(texel)) continue;
                           const auto of = static_cast<std::size_t>(surface.object(surface.triangle(t)));
                           if (of != object) take();
                           object = of;
                           places.position[places.size] = map.position_mm(texel);
                           places.texel[places.size++] = i;
                         }
                         take();
                       });
}

SurfaceParameter wood_parameter(std::string name, const WoodGrainOptions& options, const Scene& scene,
                                const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const RunControl& control) {
  const SceneMesh own = in_own_places(scene, scene_mesh);
  std::vector<std::int64_t> numbers;
  for (const SceneObject& object : scene.objects) numbers.push_back(seed_of(object.name, 0) >> 24);
  const Boards boards = find_boards(own, numbers);
  const TileGrid& grid = surface.grid();
  const TexelMap map(own.mesh, grid.width, grid.height, control);
  const double least_mm = 2.0 * surface.median_texel_size_mm();
  return coded(std::move(name), surface, control, [&](TexelIndex t, std::size_t) {
    const TexelId texel = TexelId{grid.y(t)} * grid.width + grid.x(t);
    if (!map.is_covered(texel)) return 0.5;
    const int board = boards.of_triangle[surface.triangle(t)];
    return wood_grain_at(map.position_mm(texel), boards.boards[board], options, least_mm);
  });
}

/// Makes maps of one scene, and what they have in common once.
class MapMaker {
 public:
  MapMaker(const Scene& scene, const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const RunControl& control)
      : scene_(scene), scene_mesh_(scene_mesh), surface_(surface), control_(control) {}

  [[nodiscard]] SurfaceParameter make(const std::string& name) {
    const auto own =
        std::find_if(scene_.maps.begin(), scene_.maps.end(), [&](const SceneMap& map) { return map.name == name; });
    if (own != scene_.maps.end()) return make(*own);
    if (name == "slope") return slope_parameter(scene_mesh_, surface_, up_of(scene_), control_);
    if (name == "noise") return noise_parameter(name, {}, scene_, scene_mesh_, surface_, control_);
    if (name == "wood_grain") return wood_parameter(name, {}, scene_, scene_mesh_, surface_, control_);
    ControlKindOptions options;
    const Vec3 up = up_of(scene_);
    options.up = {up.x(), up.y(), up.z()};
    options.facing.direction = options.up;
    return of_kind(name, name, options);
  }

 private:
  [[nodiscard]] SurfaceParameter make(const SceneMap& map) {
    if (map.kind == "noise") return noise_parameter(map.name, map.noise, scene_, scene_mesh_, surface_, control_);
    if (map.kind == "wood_grain")
      return wood_parameter(map.name, map.wood_grain, scene_, scene_mesh_, surface_, control_);
    if (map.kind == "image") return image_parameter(map, scene_, scene_mesh_, surface_, control_);
    if (map.kind == "objects") {
      return coded(map.name, surface_, control_, [&](TexelIndex, std::size_t object) {
        return object < map.is_inside.size() && map.is_inside[object] ? 1.0 : 0.0;
      });
    }
    return of_kind(map.name, map.kind, map.options);
  }

  [[nodiscard]] SurfaceParameter of_kind(const std::string& name, const std::string& kind,
                                         const ControlKindOptions& options) {
    if (!map_) {
      map_ = std::make_unique<const TexelMap>(scene_mesh_.mesh, scene_.resolution, scene_.resolution, control_);
    }
    try {
      return map_parameter(name, make_control(kind, *map_, options, control_).values, surface_);
    } catch (const InvalidInput& e) {
      throw InvalidInput("map `" + name + "`: " + e.what());
    }
  }

  const Scene& scene_;
  const SceneMesh& scene_mesh_;
  const SurfaceAtlas& surface_;
  const RunControl& control_;
  std::unique_ptr<const TexelMap> map_;
};

}  // namespace

SceneMesh in_own_places(const Scene& scene, const SceneMesh& scene_mesh) {
  Scene own;
  own.objects = scene.objects;
  for (SceneObject& object : own.objects) object.translate_mm = object.rotate_deg = Vec3::Zero();
  SceneMesh there = scene_mesh;
  place_objects(there, own);
  return there;
}

std::vector<std::string> map_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneMap& map : scene.maps) names.push_back(map.name);
  return names;
}

std::vector<SurfaceParameter> make_parameters(std::span<const std::string> names, const Scene& scene,
                                              const SceneMesh& scene_mesh, const SurfaceAtlas& surface,
                                              const RunControl& control) {
  std::vector<SurfaceParameter> parameters;
  MapMaker maker(scene, scene_mesh, surface, control);
  for (const std::string& name : names) parameters.push_back(maker.make(name));
  return parameters;
}

}  // namespace patinate::simulation
