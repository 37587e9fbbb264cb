/// \file
/// A wall with sills: where rain runs off, and what it carries, makes streaks. For simulations.
#pragma once

#include <string>

#include "libcommon/core/options.h"
#include "libcommon/geometry/mesh.h"

namespace patinate {

/// Settings of ledge().
struct LedgeOptions {
  double width_mm = 1000.0;    ///< Of the wall; > 0. It is as high as wide, and a tenth as thick.
  double depth_mm = 90.0;      ///< By how much the sills stand out; > 0, at most a fifth of the width.
  double thickness_mm = 30.0;  ///< Of a sill's front; > 0, at most a tenth of the width.
  int num_sills = 3;           ///< [1, 6].
  int cells = 24;              ///< Squares along the wall; [1, 400].
};

void describe(OptionVisitor& v, LedgeOptions& o);

/// A mesh in mm, y up, the wall's front in the plane z = 0 and facing +z, its foot at y = 0, centred on x = 0. Sills fall outward on top and
/// back toward the wall below, as those do that leave streaks. Wall and sills are closed bodies that enter each other; their faces are
/// charts of one atlas of even density without overlaps, 3 texels apart on 1024.
/// @throws InvalidInput
[[nodiscard]] Mesh ledge(const LedgeOptions& options = {});

/// A scene file for it (`patinate.scene`): rain from the front and above carries dirt from the ledge down the wall.
[[nodiscard]] std::string ledge_scene(const LedgeOptions& options, const std::string& mesh_file);

}  // namespace patinate
