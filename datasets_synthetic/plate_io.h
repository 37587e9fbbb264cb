/// \file
/// The glossy plate as a capture project for `patinate ingest`, with its truth beside it.
#pragma once

#include <filesystem>

#include "datasets_synthetic/plate.h"
#include "libcommon/job/job.h"

namespace patinate::datasets {

/// Plan that writes, into `output`: `capture.json` (with the camera's and the lamp's places), `frames/0000.png ...` -
/// what a lab would have; and `truth/albedo/0000.exr ...`, `truth/patina/0000.exr ...` (share of a place that it
/// covers), `truth/specular/0000.exr ...` (F0, its mean over channels, and roughness, which is the mean by F0 where
/// polish and patina share a place) and `truth/truth.json` (options and `"key"`; the plan's manifest).
/// @throws InvalidInput if an option is out of range.
[[nodiscard]] JobPlan plan_plate(const PlateOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
