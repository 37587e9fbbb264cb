/// \file
/// From a capture project to a material history.
#pragma once

#include <filesystem>

#include "capture/background/background.h"
#include "capture/project/capture_project.h"
#include "capture/project/progress_control.h"
#include "capture/project/scan_control.h"
#include "capture/timelapse/repair.h"
#include "libcommon/job/job.h"
#include "patinate/capture/thickness.h"
#include "patinate/core/options.h"

namespace patinate::capture {

/// How a transmission photograph was aligned: `homography` (frames from photograph), `agreeing`, `residual_px`,
/// `correlation`.
inline constexpr const char* kTransmissionFile = "transmission.json";

/// Settings of plan_ingest() that are not facts about the photographs (those stand in the project).
struct IngestOptions {
  bool add_progress = false;        ///< Make the `progress` control also beside measured ones.
  bool add_deviations = false;      ///< Write the standard deviation of every frame's color, estimate_noise().
  ThicknessOptions thickness = {};  ///< For projects with a transmission photograph.
  ProgressOptions progress = {};
  RepairOptions repair = {};  ///< Survey, repairs and masks of a time-lapse.
  ScanOptions scan = {};      ///< For projects with a scan.
  BackgroundOptions background = {};
  AlignOptions align = {};     ///< For read_capture_project(); here for the command line.
  ChartOptions chart = {};     ///< Likewise.
  bool accept_failed = false;  ///< Leave photographs that cannot be aligned out, instead of stopping.
};
void describe(OptionVisitor& v, IngestOptions& o);

/// Plan that writes the history of a project into `output`: one item per frame, in any order and memory that does not
/// depend on their number; then the mask, the controls and history.json.
///
/// Controls: those given; `thickness` (relative) if there is a transmission photograph;
/// `accessibility` (1/mm, scan_maps()) if there is a scan, with maps of position, normal and texel size; `progress`
/// (relative, progress_from_history()) if there would be none otherwise and there is more than one frame, or
/// `add_progress`. The key covers the photographs and maps by content, times, options and the version of this stage;
/// not their paths. A frame's own key covers its photograph and how it is developed, so that finished frames stay in a
/// partial history when another photograph is repaired or added after them.
/// @throws InvalidInput if an option is out of range or `progress` is both given and asked for; IoError if a file
/// cannot be read.
[[nodiscard]] JobPlan plan_ingest(const CaptureProject& project, const IngestOptions& options,
                                  const std::filesystem::path& output);

}  // namespace patinate::capture
