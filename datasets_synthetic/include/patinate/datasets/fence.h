/// \file
/// A wooden fence: planks, rails and posts, with grain. For simulations of what weather makes of wood.
#pragma once

#include <cstdint>
#include <string>

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

}  // namespace patinate::datasets
