/// \file
/// A wall with sills: where rain runs off, and what it carries, makes streaks. For simulations.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "patinate/core/options.h"
#include "patinate/geometry/mesh.h"

namespace patinate::datasets {

/// What happens to the wall in ledge_scene().
enum class LedgeWeather {
  Dust,  ///< Dust settles on the sills, and rain takes it round their edges and down the wall.
  Soot   ///< Soot darkens everything; then it rains, and what the rain reaches is washed clean.
};
inline constexpr std::array<std::string_view, 2> kWeatherNames{"dust", "soot"};

/// Settings of ledge().
struct LedgeOptions {
  double width_mm = 1000.0;    ///< Of the wall; > 0. It is as high as wide, and a tenth as thick.
  double depth_mm = 90.0;      ///< By how much the sills stand out; > 0, at most a fifth of the width.
  double thickness_mm = 30.0;  ///< Of a sill's front; > 0, at most a tenth of the width.
  int num_sills = 3;           ///< [1, 6].
  int cells = 24;              ///< Squares along the wall; [1, 400].
  int num_charts =
      1;  ///< Charts that a face is cut into along its longer side, each turned by an angle of its own; [1, 24].
  LedgeWeather weather = LedgeWeather::Dust;
};

void describe(OptionVisitor& v, LedgeOptions& o);

/// A mesh in mm, y up, the wall's front in the plane z = 0 and facing +z, its foot at y = 0, centered on x = 0. Sills
/// fall outward on top and back toward the wall below, as those do that leave streaks. Wall and sills are closed bodies
/// that enter each other; their faces are charts of one atlas of even density without overlaps, 3 texels apart on 1024.
/// @throws InvalidInput
[[nodiscard]] Mesh ledge(const LedgeOptions& options = {});

/// A scene file for it (`patinate.scene`), by options.weather.
[[nodiscard]] std::string ledge_scene(const LedgeOptions& options, const std::string& mesh_file);

}  // namespace patinate::datasets
