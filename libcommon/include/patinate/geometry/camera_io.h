/// \file
/// Cameras from calibration files of OpenCV, COLMAP, Middlebury and from our JSON files. Files are not trusted: every
/// count is bounded.
#pragma once

#include <filesystem>

#include "patinate/core/json.h"
#include "patinate/geometry/camera.h"

namespace patinate {

/// A camera of
/// - OpenCV (cv::FileStorage: .yml, .xml, .json), at most 1 MB, with `image_width`, `image_height`, `camera_matrix` (3
/// x 3, no skew),
///   `distortion_coefficients` (4 or 5, or more when the rest are 0; also `dist_coeffs`), `rotation` (3 x 3, or an axis
///   times an angle; also `R`, `rvec`) and `translation` (also `T`, `t`, `tvec`). A missing pose is an error:
///   calibration programs leave it out, and no guess would be right;
/// - a calibration of ours (.json), which says its own unit;
/// - a COLMAP model of one image, text or binary: its folder or one of its files.
/// A lens model that is said and is not Brown's (fisheye, omnidirectional, ...) is refused by its name.
/// @param mm_per_unit  Of the file's world; the camera's is in mm. 1 keeps the file's unit.
/// @throws IoError naming the key or line.
[[nodiscard]] Camera read_camera(const std::filesystem::path& path, double mm_per_unit = 1.0);

/// A path as above; {"width", "height", "matrix", "distortion" (4 or 5; none when not given), "rotation" (3 x 3 or axis
/// times angle), "translation"}; or one image of several, {"file": COLMAP's folder, "image": name} or {"file":
/// Middlebury's _par.txt, "image", "width", "height"}.
/// @throws IoError
[[nodiscard]] Camera read_camera(JsonReader json, double mm_per_unit = 1.0);

/// The object form; values read back exactly.
[[nodiscard]] Json json_of(const Camera& camera);
/// An OpenCV calibration (YAML) that cv::FileStorage and read_camera() read back exactly.
[[nodiscard]] std::string opencv_text(const Camera& camera);

}  // namespace patinate
