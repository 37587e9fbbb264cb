/// \file
/// Says of how many pixels a history does not hold the color that the photographs have. Inside of ingest only.
#pragma once

#include <filesystem>
#include <vector>

#include "capture/project/capture_project.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// @param folder  Of the history, whose frames are finished.
[[nodiscard]] std::vector<HistoryWarning> clipping_warnings(const CaptureProject& project,
                                                            const std::filesystem::path& folder);

}  // namespace patinate::capture
