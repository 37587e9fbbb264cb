/// \file
/// Cameras from files of multi-view programs: COLMAP's models, Middlebury's `_par.txt`. Files are not trusted:
/// every count is bounded.
#pragma once

#include <filesystem>
#include <string>

#include "patinate/geometry/camera.h"

namespace patinate {

/// One image of a COLMAP model. Text: `images.txt` (two lines an image: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME,
/// then its 2-D points, which may be an empty line) and the `cameras.txt` beside it. SIMPLE_PINHOLE, PINHOLE,
/// SIMPLE_RADIAL, RADIAL, OPENCV, and FULL_OPENCV without k4 k5 k6. COLMAP's pixel centers are at halves, ours at
/// integers: 0.5 is taken off the principal point. Its world has no unit.
/// Binary, where there is no text: `images.bin` and `cameras.bin`.
/// @param path   The model's folder, or one of these files.
/// @param image  NAME, or its last part; "" = the only one.
/// @throws IoError naming the line, the images there are, or the lens model that is not read.
[[nodiscard]] CameraParameters read_colmap_camera(const std::filesystem::path& path, const std::string& image = "");

/// One image of a Middlebury multi-view `NAME_par.txt`: the number of images, then `image k11 k12 ... k33 r11 ... r33
/// t1 t2 t3` each, row by row, x_in_picture = K (R x_in_world + t). No distortion. The file does not say how large
/// pictures are.
/// @throws IoError naming the line, also when K has skew, or R is no rotation to 1e-3 (they are printed with few
/// digits).
[[nodiscard]] CameraParameters read_middlebury_camera(const std::filesystem::path& path, const std::string& image,
                                                      int width, int height);

}  // namespace patinate
