/// \file
/// The dusty urn as a capture project for `patinate ingest`, with its truth beside it.
#pragma once

#include <filesystem>

#include "datasets_synthetic/dust.h"
#include "libcommon/job/job.h"

namespace patinate::datasets {

/// Plan that writes, into `output`: `capture.json`, `frames/0000.png ...`, `mesh.obj` (mm), `mask.png` and the control
/// that dust follows, `facing.exr` or `exposure.exr` - what a lab would have; and `truth/albedo/0000.exr ...`,
/// `truth/cover/0000.exr ...`, `truth/specular/0000.exr ...` (strength, roughness) of every photograph,
/// `truth/position.exr` (mm), `truth/normal.exr`, `truth/facing.exr`, `truth/exposure.exr`, `truth/light.exr`, and
/// `truth/truth.json` (options and `"key"`; the plan's manifest). All of them of what pixels' centers see.
/// @throws InvalidInput if an option is out of range.
[[nodiscard]] JobPlan plan_dust(const DustOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
