/// \file
/// One step, from its file to a folder of maps: what `patinate unlight` does.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "capture/unlighting/unlight_step.h"
#include "capture/unlighting/unlit_document.h"
#include "libcommon/job/job.h"

namespace patinate::capture {

inline constexpr const char* kUnlitPageFile = "report.html";

/// Plan that writes `albedo.exr`, `stddev.exr`, `normal.exr`, `specular.exr` (strength, roughness), `mask.png`,
/// pictures of them (`albedo.png`, `normal.png`, ...), `samples/01.png` ... (what became of every photograph's pixels),
/// `report.html`, and `unlight.json` (docs/schema/unlit.schema.json).
/// @throws InvalidInput if an option is out of range; IoError if a photograph cannot be read.
[[nodiscard]] JobPlan plan_unlight(const UnlightStep& step, const UnlightOptions& options,
                                   const std::filesystem::path& output);

/// The options for content keys and provenance; without those that change nothing while they are off.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> key_values(const UnlightOptions& options);

}  // namespace patinate::capture
