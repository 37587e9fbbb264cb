/// \file
/// The drying patch as a capture project for `patinate ingest`, with its truth beside it.
#pragma once

#include <filesystem>

#include "datasets_synthetic/drying.h"
#include "libcommon/job/job.h"

namespace patinate::datasets {

/// Plan that writes, into `output`: `capture.json`, `frames/0000.png ...` - what a lab would have; and
/// `truth/albedo/0000.exr ...`, `truth/wetness/0000.exr ...`, `truth/specular/0000.exr ...` (strength, roughness) of
/// every photograph, `truth/onset.exr` (min, -1 outside the patch), `truth/film.exr` (mm), and `truth/truth.json`
/// (options and `"key"`; the plan's manifest).
/// @throws InvalidInput if an option is out of range.
[[nodiscard]] JobPlan plan_drying(const DryingOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
