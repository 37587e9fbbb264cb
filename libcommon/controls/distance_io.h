/// \file
/// Curves from CSV files.
#pragma once

#include <filesystem>
#include <vector>

#include "patinate/geometry/mesh.h"

namespace patinate {

/// One point a line, `x,y,z` in mm. Points that follow each other are a curve; an empty line ends it. Lines that begin
/// with `#` and a first line of names are skipped. @throws IoError naming the line; if there is no point, or more than
/// 100,000.
[[nodiscard]] std::vector<std::vector<Vec3>> read_curves(const std::filesystem::path& path);

}  // namespace patinate
