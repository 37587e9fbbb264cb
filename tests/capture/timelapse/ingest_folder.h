/// \file
/// Ingesting the project that lies in a folder, as most tests of ingest do.
#pragma once

#include <filesystem>
#include <string>

#include "capture/timelapse/ingest.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history.h"

namespace patinate::testing_support {

/// Ingests `folder / "capture.json"` into `folder / "out"`.
[[nodiscard]] HistoryReader ingest(const std::filesystem::path& folder, const capture::IngestOptions& options = {},
                                   const RunControl& control = {});
/// Error of the ingest; "" when nothing is wrong.
[[nodiscard]] std::string ingest_error(const std::filesystem::path& folder, const capture::IngestOptions& options = {});

}  // namespace patinate::testing_support
