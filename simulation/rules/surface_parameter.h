/// \file
/// What drivers of rules may ask for besides materials: values of the surface that no rule changes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "patinate/simulation/surface_atlas.h"

namespace patinate::simulation {

/// Tells names that change with time and are the same everywhere: the scene's time ("age") and kWeatherSignalNames.
[[nodiscard]] bool is_time_signal(std::string_view name);

/// Names that a driver may use beside the materials: built_in_maps(), "slope", "age", the weather's signals, maps of
/// the scene, and, where it has layers, layer_value_names().
[[nodiscard]] std::vector<std::string> driver_names(std::span<const std::string> materials,
                                                    std::span<const std::string> maps,
                                                    std::span<const std::string> layers = {});

/// One value for each texel, in tile order (TileGrid::index), coded to save memory: low + (high - low) * code / 255 (or
/// / 65535).
struct SurfaceParameter {
  std::string name;  ///< Name as drivers have it.
  std::variant<std::vector<std::uint8_t>, std::vector<std::uint16_t>, std::vector<float>>
      values;        ///< Floats: finite; as they are.
  float low = 0.0F;  ///< Range of codes.
  float high = 1.0F;
};

/// Value of one code step.
[[nodiscard]] float code_step(const SurfaceParameter& parameter);
/// The values of a tile. @param out  TileGrid::kTileTexels.
void load_parameter(const SurfaceParameter& parameter, TileIndex tile, float* out);

/// Asks memory for what load_parameter() will read.
void prefetch_parameter(const SurfaceParameter& parameter, TileIndex tile);
/// The value of one texel.
[[nodiscard]] double parameter_at(const SurfaceParameter& parameter, TexelIndex texel);

/// How far a place is from level ground: (1 - n . up) / 2; 0 = level, 0.5 = a wall, 1 = a ceiling. By the
/// mesh's normals, interpolated, on the side that the triangle faces.
/// @param up  Unit; against gravity.
[[nodiscard]] SurfaceParameter slope_parameter(const SceneMesh& scene_mesh, const SurfaceAtlas& surface, const Vec3& up,
                                               const RunControl& control = {});

/// A map of the atlas (row by row, as wide and high as the grid) in [0, 1] as a parameter of 16-bit codes; what is not
/// covered is 0.
/// @throws InvalidInput if its size is not the grid's.
[[nodiscard]] SurfaceParameter map_parameter(std::string name, const ImageF& map, const SurfaceAtlas& surface);

}  // namespace patinate::simulation
