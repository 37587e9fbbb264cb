/// \file
/// A history of part of another one's frames, as a job: for the command and the Python module.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "patinate/history/trim_history.h"

namespace patinate::app {

/// @param history  A history's folder. @throws IoError; InvalidInput as trim_history().
[[nodiscard]] JobPlan plan_trim(const std::filesystem::path& history, const TrimOptions& options,
                                const std::filesystem::path& output);

}  // namespace patinate::app
