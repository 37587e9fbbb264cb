/// \file
/// What is said of photographs that were laid over one another.
#pragma once

#include <filesystem>
#include <vector>

#include "capture/timelapse/ingest_work.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// Completes survey.json by `alignment` (every photograph's status and residual) and says what is to be warned of:
/// photographs that were left out, fit badly, are much coarser than the reference, or show little of its frame.
/// Nothing of a history whose photographs were not matched.
[[nodiscard]] std::vector<HistoryWarning> report_alignment(const IngestWork& work, const std::filesystem::path& folder);

}  // namespace patinate::capture
