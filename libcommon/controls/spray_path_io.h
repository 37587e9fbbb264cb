/// \file
/// Nozzle paths and strokes from files.
#pragma once

#include <filesystem>
#include <vector>

#include "patinate/controls/spray.h"

namespace patinate {

/// A path of single stops, or painted strokes, by what the file is.
///
/// CSV, one stop a line: `x,y,z[,dwell[,aim_x,aim_y,aim_z]]`, mm; dwell 1 and `default_aim_mm` when omitted. Empty
/// lines and lines that begin with `#` are skipped, and so is a first line of names. CSV whose first line names
/// columns, `stroke` among them: painted strokes (stroke_stops()). Columns stroke,x,y,z and any of aim_x,aim_y,aim_z or
/// direction_x,direction_y,direction_z, spread (deg), flow, dwell; lines of one stroke follow each other and carry the
/// same word under `stroke`; its flow is that of its first line. Empty fields are as if omitted. JSON (.json):
/// {"format": "patinate.strokes", "version": 1, "strokes": [{"flow": 1, "spread": 12, "points": [{"position": [x,y,z],
/// "aim": [x,y,z] or "direction": [x,y,z], "dwell": 1, "spread": 12}, ...]}, ...]}; all but positions may be omitted.
/// A direction aims at the point that lies as far along it as `default_aim_mm` is away.
/// @throws IoError naming the line; if there is no stop, or more than 100,000.
[[nodiscard]] std::vector<SprayStop> read_spray_path(const std::filesystem::path& path, const Vec3& default_aim_mm,
                                                     const SprayOptions& options = {});

}  // namespace patinate
