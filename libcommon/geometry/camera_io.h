/// \file
/// Cameras from OpenCV's calibration files and from our JSON files. Files are not trusted: every count is bounded.
#pragma once

#include <filesystem>

#include "libcommon/core/json.h"
#include "libcommon/geometry/camera.h"

namespace patinate {

/// OpenCV calibration (cv::FileStorage: .yml, .xml, .json), at most 1 MB, with `image_width`, `image_height`, `camera_matrix` (3 x 3, no
/// skew), `distortion_coefficients` (4 or 5, or more when the rest are 0; also `dist_coeffs`), `rotation` (3 x 3, or an axis times an
/// angle; also `R`, `rvec`) and `translation` (also `T`, `t`, `tvec`). A missing pose is an error: calibration programs leave it out, and no
/// guess would be right.
/// @throws IoError naming the key.
[[nodiscard]] Camera read_camera(const std::filesystem::path& path);

/// A path to an OpenCV calibration, or {"width", "height", "matrix", "distortion" (4 or 5; none when not given), "rotation" (3 x 3 or axis times
/// angle), "translation"}.
/// @throws IoError
[[nodiscard]] Camera read_camera(JsonReader json);

}  // namespace patinate
