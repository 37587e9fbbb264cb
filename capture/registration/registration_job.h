/// \file
/// Registration as a job: scans in, a folder with poses, a picture and, when asked for, the moved scans out; whole or
/// absent.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/registration/joint_registration.h"
#include "libcommon/job/job.h"

namespace patinate::capture {

struct RegistrationTask {
  std::vector<std::filesystem::path> files;  ///< At least 2.
  std::vector<std::optional<RigidTransform>>
      initial;  ///< world from scan, in the files' unit: as many as files, or none.
  int reference = 0;
  std::string unit;  ///< Unit of the files: "um", "mm", "cm", "m"; "" = not said.
  RegistrationOptions options;
  bool accept_failed = false;  ///< Scans that could not be placed are excluded; without, they are an error.
  bool write_merged = false;   ///< merged.ply: all points in the reference's frame.
  bool write_scans = false;    ///< scans/NAME.ply, each moved.
};

/// Files by which a folder's scans are known: .ply, .pcd, .obj, in natural order. @throws IoError if it holds none, or
/// cannot be read
[[nodiscard]] std::vector<std::filesystem::path> scans_in_folder(const std::filesystem::path& folder);
/// The files' names; with their folders' where names are equal.
[[nodiscard]] std::vector<std::string> scan_names(const std::vector<std::filesystem::path>& files);

/// registration.json, poses.conf, registration.png, merged.ply, scans/. The run throws CannotComplete, naming scan and
/// status, when a scan could not be placed for certain and that is not accepted.
[[nodiscard]] JobPlan plan_registration(RegistrationTask task, const std::filesystem::path& output);

}  // namespace patinate::capture
