/// \file
/// The mold data set as a capture project for `patinate ingest`, with its truth beside it.
#pragma once

#include <filesystem>

#include "datasets_synthetic/mold.h"
#include "libcommon/job/job.h"

namespace patinate::datasets {

/// Plan that writes, into `output`:
/// `capture.json`, `step00/scan.ply`, `step00/light0.png ...`, `step00/dark.png` (with ambient light), ... - what a lab
/// would have; photographs are 8-bit sRGB, or float EXR when `noise` is 0. And, in the view of the reference step 0:
/// `truth/albedo/0000.exr` (one a step), `truth/specular/0000.exr` (strength, roughness), of metal
/// `truth/reflectance/0000.exr` (F0) and `truth/metalness/0000.exr`, with a relief `truth/relief/0000.exr`
/// (Mold::relief(), mm) and `truth/normals/0000.exr` (reference's frame), `truth/position.exr`, `truth/normal.exr`,
/// `truth/accessibility.exr` (1/mm, concave positive), `truth/mask.png`, `truth/lacquered.png` (where nothing ever
/// changes); in each photograph's own view `truth/in_light/00_0.png` (step, light: neither turned away nor in a cast
/// shadow); and `truth/truth.json` (options, `reference_from_scan` and gains of every step, and
/// `"key"`; the plan's manifest).
/// @throws InvalidInput if an option is out of range.
[[nodiscard]] JobPlan plan_mold(const MoldOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
