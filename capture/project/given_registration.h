/// \file
/// Poses of a relit capture from the registration.json that `register` wrote of its scans.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/project/relit_project.h"

namespace patinate::capture {

/// Statement of a registration about one scan.
struct GivenScan {
  std::string name;
  std::filesystem::path path;                         ///< "" where it does not say.
  std::optional<RigidTransform> reference_from_scan;  ///< mm; nothing where it has no place.
};
struct GivenScans {
  std::vector<GivenScan> scans;
  std::string reference;     ///< Name of the scan whose frame is common.
  double mm_per_unit = 1.0;  ///< Mm per unit of the scans' files.
};
/// @param mm_per_unit  Of the scans, where the registration does not say it. @throws IoError; also where nobody does.
[[nodiscard]] GivenScans read_given_scans(const std::filesystem::path& file, std::optional<double> mm_per_unit);

/// Gives every step with a scan and without a `transform` of its own the pose that the registration has of its scan,
/// in the frame of the project's reference step. Scans are found by their paths, else by their names.
/// @throws IoError naming the step whose scan the registration does not have, or could not place.
void apply_registration(const std::filesystem::path& file, RelitProject& project);

}  // namespace patinate::capture
