/// \file
/// The crackle data set as a capture project for `patinate ingest`, with its truth beside it.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "patinate/datasets/crackle.h"

namespace patinate::datasets {

/// Plan that writes, into `output`:
/// `capture.json`, `frames/0000.png ...`, `backlight.png`, `backlight_blank.png` - what a lab would have; and
/// `truth/thickness.exr` (mm), `truth/opening.exr` (s, -1 = never), `truth/cells.exr` (number of the cell, 0 = crack),
/// `truth/truth.json` (options, laws, counts and `"key"`; the plan's manifest).
/// @throws InvalidInput if an option is out of range.
[[nodiscard]] JobPlan plan_crackle(const CrackleOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
