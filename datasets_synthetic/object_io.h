/// \file
/// Synthetic objects as folders: a mesh to age with a transfer, or a mesh with the scene that ages it.
#pragma once

#include <filesystem>

#include "libcommon/job/job.h"
#include "patinate/datasets/objects.h"

namespace patinate::datasets {

/// `mesh.obj` (mm); `sculpture.json` is the manifest: mesh, unit, options, key. All of these @throws InvalidInput if an
/// option is out of range.
[[nodiscard]] JobPlan plan_sculpture(const SculptureOptions& options, const std::filesystem::path& output);
/// `mesh.obj` (mm), `scene.json` for `patinate simulate`; `ledge.json` is the manifest: mesh, scene, unit, key.
[[nodiscard]] JobPlan plan_ledge(const LedgeOptions& options, const std::filesystem::path& output);
/// Plans a fence, with `grain.png` (sRGB), the color of new wood; `fence.json` is the manifest.
[[nodiscard]] JobPlan plan_fence(const FenceOptions& options, const std::filesystem::path& output);

}  // namespace patinate::datasets
