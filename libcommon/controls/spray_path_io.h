/// \file
/// Nozzle paths from CSV files.
#pragma once

#include <filesystem>
#include <vector>

#include "libcommon/controls/spray.h"

namespace patinate {

/// One stop a line: `x,y,z[,dwell[,aim_x,aim_y,aim_z]]`, mm; dwell 1 and `default_aim_mm` when left out. Empty lines
/// and lines that begin with `#` are skipped, and so is a first line of names.
/// @throws IoError naming the line; if there is no stop, or more than 100,000.
[[nodiscard]] std::vector<SprayStop> read_spray_path(const std::filesystem::path& path, const Vec3& default_aim_mm);

}  // namespace patinate
