/// \file
/// Ingest of any capture with all of its options.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "capture/relit/relit_ingest.h"
#include "capture/timelapse/ingest.h"
#include "libcommon/job/job.h"

namespace patinate::capture {

/// Names of IngestOptions that mean nothing for scans under lamps.
inline constexpr std::array<std::string_view, 11> kFixedCameraOptions{
    "align",      "chart",     "align_model", "align_to",   "mask_background", "static_light",
    "deviations", "stabilize", "deflicker",   "flat_field", "highlights"};

/// Names of RelitOptions that mean nothing without lamps: all but `accept_failed`.
[[nodiscard]] std::vector<std::string> lamp_options();

/// plan_ingest() of a time-lapse, plan_relit_ingest() of scans under lamps. What both have is said once:
/// `accept_failed` in `relit`, scan, fill and progress in `options`. @param capture  A capture.json, or the folder that
/// holds it. @throws as these; InvalidInput if scans under lamps come with one of kFixedCameraOptions,
/// or a fixed camera with one of lamp_options().
[[nodiscard]] JobPlan plan_history(const std::filesystem::path& capture, const std::filesystem::path& output,
                                   IngestOptions options, RelitOptions relit);

}  // namespace patinate::capture
