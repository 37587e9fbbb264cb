#include "simulation/rules/surface_parameter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/simulation/scene_map.h"
#include "patinate/simulation/weather.h"
#include "simulation/rules/layer_values.h"
#include "simulation/rules/rule_kernel.h"

namespace patinate::simulation {

bool is_time_signal(std::string_view name) { return name == "age" || weather_signal_of(name).has_value(); }

std::vector<std::string> driver_names(std::span<const std::string> materials, std::span<const std::string> maps,
                                      std::span<const std::string> layers) {
  std::vector<std::string> names(materials.begin(), materials.end());
  const auto add = [&](std::string_view name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  };
  for (const std::string& name : maps) add(name);
  for (const std::string& name : built_in_maps()) add(name);
  add("slope");
  add("age");
  for (const std::string_view name : kWeatherSignalNames) add(name);
  if (layers.empty()) return names;
  for (const std::string& name : layer_value_names(materials)) add(name);
  return names;
}

float code_step(const SurfaceParameter& parameter) {
  const bool is_byte = std::holds_alternative<std::vector<std::uint8_t>>(parameter.values);
  return (parameter.high - parameter.low) / (is_byte ? 255.0F : 65535.0F);
}

void load_parameter(const SurfaceParameter& parameter, TileIndex tile, float* out) {
  const std::size_t first = std::size_t{tile} * TileGrid::kTileTexels;
  const auto decode = [&](const auto& codes, float step) {
    for (std::size_t i = 0; i < TileGrid::kTileTexels; ++i)
      out[i] = rule_types::decoded(codes[first + i], parameter.low, step);
  };
  if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&parameter.values)) {
    decode(*bytes, code_step(parameter));
  } else if (const auto* words = std::get_if<std::vector<std::uint16_t>>(&parameter.values)) {
    decode(*words, code_step(parameter));
  } else {
    const auto& floats = std::get<std::vector<float>>(parameter.values);
    std::copy_n(floats.begin() + static_cast<std::ptrdiff_t>(first), TileGrid::kTileTexels, out);
  }
}

void prefetch_parameter(const SurfaceParameter& parameter, TileIndex tile) {
  constexpr std::size_t kLine = 64;  // Bytes of a cache line.
  std::visit(
      [&](const auto& values) {
        const auto* first = reinterpret_cast<const char*>(values.data() + std::size_t{tile} * TileGrid::kTileTexels);
        for (std::size_t b = 0; b < TileGrid::kTileTexels * sizeof(values[0]); b += kLine)
          __builtin_prefetch(first + b);
      },
      parameter.values);
}

double parameter_at(const SurfaceParameter& parameter, TexelIndex texel) {
  std::array<float, TileGrid::kTileTexels> tile;
  load_parameter(parameter, TileGrid::tile_of(texel), tile.data());
  return static_cast<double>(tile[texel % TileGrid::kTileTexels]);
}

SurfaceParameter slope_parameter(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const Vec3& up,
                                 const RunControl& control) {
  const Mesh& mesh = scene_mesh.mesh;
  constexpr double kCancelled = 1e-3;  // of normals of length 1
  std::vector<std::uint16_t> values(surface.grid().num_texels());
  parallel_for(std::int64_t{surface.grid().num_texels()}, 16384, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<TexelIndex>(begin); t < static_cast<TexelIndex>(end); ++t) {
      if (!surface.is_covered(t)) continue;
      const auto triangle = static_cast<std::size_t>(surface.triangle(t));
      const Vec3 area = area_vector(mesh, surface.triangle(t));
      const std::array<double, 3> weights = surface.corner_weights(t);
      Vec3 normal = Vec3::Zero();
      for (std::size_t k = 0; k < 3 && !mesh.normals.empty(); ++k)
        normal += weights[k] * mesh.normals[mesh.normal_triangles[triangle][k]];
      if (normal.norm() < kCancelled) normal = area;
      if (normal.dot(area) < 0.0) normal = -normal;
      const double length = normal.norm();
      const double slope = length > 0.0 ? (1.0 - normal.dot(up) / length) / 2.0 : 0.0;
      values[t] = static_cast<std::uint16_t>(std::floor(std::clamp(slope, 0.0, 1.0) * 65535.0 + 0.5));
    }
  });
  return {.name = "slope", .values = std::move(values)};
}

SurfaceParameter map_parameter(std::string name, const ImageF& map, const SurfaceAtlas& surface) {
  const TileGrid& grid = surface.grid();
  if (map.width() != grid.width || map.height() != grid.height || map.channels() != 1) {
    throw InvalidInput("the map of `" + name + "` is " + size_text(map.width(), map.height()) + "; the atlas is " +
                       size_text(grid.width, grid.height));
  }
  std::vector<std::uint16_t> values(grid.num_texels());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const double value = static_cast<double>(map.at(x, y));
      if (surface.is_covered(grid.index(x, y)) && value > 0.0)
        values[grid.index(x, y)] = static_cast<std::uint16_t>(std::floor(std::min(value, 1.0) * 65535.0 + 0.5));
    }
  }
  return {.name = std::move(name), .values = std::move(values)};
}

}  // namespace patinate::simulation
