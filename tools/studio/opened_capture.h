/// \file
/// The project of a capture with one camera, for pages on which a person works with its photographs.
#pragma once

#include <filesystem>
#include <mutex>
#include <string>

#include "capture/project/capture_project.h"
#include "patinate/core/json.h"
#include "tools/studio/routes.h"

namespace patinate::studio {

/// The project file that a request names. @throws NotFound; InvalidInput if it is no capture of kind `fixed`.
[[nodiscard]] std::filesystem::path fixed_capture_file(const Asked& asked);
/// For who saves a project: when two save at once, the second finds the first one's state.
[[nodiscard]] std::mutex& project_mutex();
/// Relative to a folder, as the browser may ask for it; "" of what it may not.
[[nodiscard]] std::string shown_path(const std::filesystem::path& folder, const std::filesystem::path& file);
/// {"name", "path", "width", "height"}, of an image of a movie its number "image", too; null if it lies elsewhere.
[[nodiscard]] Json photo_json(const std::filesystem::path& folder, const capture::CapturePhoto& photo,
                              const std::string& name);
/// The photographs of a project, each with its "number" and "time". Those that lie elsewhere are left out.
[[nodiscard]] Json photos_json(const capture::CaptureProject& project);

}  // namespace patinate::studio
