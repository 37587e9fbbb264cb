/// \file
/// Ingest of any capture with all of its options.
#pragma once

#include <filesystem>

#include "capture/relit/relit_ingest.h"
#include "capture/timelapse/ingest.h"
#include "libcommon/job/job.h"

namespace patinate::capture {

/// plan_ingest() of a time-lapse, plan_relit_ingest() of scans under lamps. What both have is said once:
/// `accept_failed` in `relit`, scan, fill and progress in `options`. @param capture  A capture.json, or the folder that
/// holds it. @throws as these.
[[nodiscard]] JobPlan plan_history(const std::filesystem::path& capture, const std::filesystem::path& output,
                                   IngestOptions options, RelitOptions relit);

}  // namespace patinate::capture
