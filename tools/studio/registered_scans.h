/// \file
/// Registered scans in one frame: what a registration folder says of them, and the scans themselves where they are
/// served.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/rigid_transform.h"
#include "tools/studio/served_folder.h"

namespace patinate::studio {

struct PlacedScan {
  std::string name;       ///< Name as registration.json has it.
  std::string status;     ///< "converged", "poor fit", ...
  double residual = 0.0;  ///< In the scans' unit.
  double overlap = 0.0;   ///< Share; with `partner`.
  std::string partner;    ///< "" = none.
  RigidTransform reference_from_file;
  std::optional<std::filesystem::path> file;  ///< Nothing: it has no place, or its file is not below the served folder.
  std::string problem;                        ///< Why there is no file; "" when there is one.
};

/// A folder of `register`.
struct RegisteredScans {
  std::string reference, unit;  ///< unit "" = not said.
  std::vector<PlacedScan> scans;
};

/// @param place  A folder of `register`. @throws IoError
[[nodiscard]] RegisteredScans read_registration(const std::filesystem::path& place, const ServedFolder& folder);
/// [{"name", "status", "residual", "overlap", "partner", "is_reference", "is_shown", "text"}]
[[nodiscard]] Json scans_json(const RegisteredScans& registration);
/// One node a scan that has a file, in the reference's frame; surfaces where the file knows any, points else. A few
/// million triangles at most: of more, all scans come as points, evenly thinned.
[[nodiscard]] std::string registered_scans_glb(const RegisteredScans& registration, const RunControl& control);

}  // namespace patinate::studio
