/// \file
/// A command that `patinate studio` has started: what a browser asked for, so it touches nothing outside the folders
/// that the studio may touch, and says more often how far it is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/core/read_limit.h"

namespace patinate::cli {

/// The variable of the environment that makes a command such a job.
inline constexpr const char* kStudioJobVariable = "PATINATE_STUDIO_JOB";

struct StudioJobFolders {
  std::vector<std::filesystem::path> read, written;
};
/// For the variable. @param folders  All of them exist.
[[nodiscard]] std::string studio_job_text(const StudioJobFolders& folders);
[[nodiscard]] bool is_studio_job();

/// Keeps this process to its folders while it lives, and ends it with the studio. Does nothing in other commands.
class StudioJob {
 public:
  /// Call it before any thread starts. @throws InvalidInput if the variable holds something else; IoError
  StudioJob();

 private:
  std::optional<ReadLimit> read_;
  std::optional<WriteLimit> written_;
};

}  // namespace patinate::cli
