/// \file
/// Procedural objects that age, each with an atlas by construction: a wooden fence with grain, for what weather makes
/// of wood; a wall with sills, where rain runs off and what it carries makes streaks; and a lidded urn with handles, a
/// sculptural mesh with concavities.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// Settings of fence().
struct FenceOptions {
  double height_mm = 900.0;  ///< > 0.
  int num_planks = 8;        ///< [1, 40]; a ninth of the height wide each, and no two alike.
  int cells = 12;            ///< Squares along the height; [1, 200].
  int texture_px = 1024;     ///< Of the picture of its grain; [16, 4096].
  std::int64_t seed = 1;     ///< Other planks, other grain; >= 0.
};

void describe(OptionVisitor& v, FenceOptions& o);

/// A mesh in mm, y up, planks' fronts near the plane z = 0 and facing +z, the ground at y = 0, centered on x = 0. Two
/// rails run across in front of the planks, a post stands on each side; planks end above the ground. Bodies are closed
/// and enter each other; their faces are charts of one atlas of even density without overlaps.
/// @throws InvalidInput
[[nodiscard]] Mesh fence(const FenceOptions& options = {});

/// The grain of its wood, over the UVs of fence(): linear RGB, texture_px squared; along planks, posts and rails, each
/// with a tint of its own. Gutters have the wood's mean color.
[[nodiscard]] ImageF fence_grain(const FenceOptions& options = {}, const RunControl& control = {});

/// A scene file for it (`patinate.scene`): sun grays the wood, rain wets it, what stays wet decays and grows green.
[[nodiscard]] std::string fence_scene(const FenceOptions& options, const std::string& mesh_file,
                                      const std::string& grain_file);

/// Weather of the wall in ledge_scene().
enum class LedgeWeather {
  Dust,  ///< Dust settles on the sills, and rain takes it round their edges and down the wall.
  Soot   ///< Soot darkens everything; then it rains, and what the rain reaches is washed clean.
};
inline constexpr std::array<std::string_view, 2> kWeatherNames{"dust", "soot"};

/// Settings of ledge().
struct LedgeOptions {
  double width_mm = 1000.0;    ///< Width of the wall; > 0. It is as high as wide, and a tenth as thick.
  double depth_mm = 90.0;      ///< Depth of the sills; > 0, at most a fifth of the width.
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

/// Settings of sculpture().
struct SculptureOptions {
  double height_mm = 200.0;    ///< > 0.
  int resolution = 76;         ///< Height over the length of an edge; [24, 400]. Triangles grow with its square.
  int num_flutes = 20;         ///< Around the lower belly; [0, 60].
  double flute_depth = 0.040;  ///< In radii of the belly; [0, 0.08].
  double relief = 0.032;       ///< Height of the carved band, in radii of the belly; [0, 0.06].
  double twist_deg = 28.0;     ///< By how much the flutes wind; [-90, 90].
};

void describe(OptionVisitor& v, SculptureOptions& o);

/// A mesh in mm, y up, standing on y = 0: an urn (surface of revolution with flutes and a carved band) with foot, lid
/// and finial, and two handles that enter its body. The three parts are closed and consistently oriented; normals are
/// per vertex. UVs are 16 charts, rectangles along the profile and the handles, discs at ends; they do not overlap and
/// are not mirrored. The length on the surface that a texel shows, the longest and the shortest direction of every
/// triangle taken together, differs by less than a factor of 3 between the 1st and the 99th percentile, and by less
/// than 6 between extremes. About 60 000 triangles at the defaults. No random choices.
/// @throws InvalidInput
[[nodiscard]] Mesh sculpture(const SculptureOptions& options = {});

}  // namespace patinate::datasets
