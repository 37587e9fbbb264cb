/// \file
/// The coated panel as a capture project for `patinate ingest`, with its truth beside it.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "patinate/datasets/panel.h"

namespace patinate::datasets {

/// Plan that writes, into `output`: `capture.json`, `frames/0000.png ...` - what a lab would have; and, of every
/// photograph, `truth/rust/0000.exr ...`, with a scribe `truth/scribe/...`, with stains `truth/stain/...` and with
/// cracks `truth/cracks/...` (as PanelFrame has them), `truth/test_area.exr`, and `truth/truth.json` (options, spots,
/// cracks, scribe, the figures of every photograph and `"key"`; the plan's manifest).
/// @throws InvalidInput as make_panel().
[[nodiscard]] JobPlan plan_panel(const PanelOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
