/// \file
/// What COLMAP's text and binary models share, and the binary one. Files are not trusted: every count is bounded.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "patinate/geometry/camera.h"

namespace patinate {

inline constexpr const char* kColmapLensHelp =
    "expected SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL or OPENCV: undistort with `colmap image_undistorter`";

/// Number of parameters of a lens model that is read; 0 for another name.
[[nodiscard]] std::size_t num_colmap_parameters(std::string_view model);
/// Sets focal lengths, principal point and distortion. COLMAP's pixel centers are at halves, ours at integers.
/// @param values  num_colmap_parameters(model) of them. @returns what is wrong; "" = nothing
[[nodiscard]] std::string set_colmap_lens(std::string_view model, std::span<const double> values, CameraParameters& p);

/// Whether an image is meant: its name, or its last part; "" = any.
[[nodiscard]] bool is_colmap_image(std::string_view name, const std::string& wanted);

/// One image of a binary model: `images.bin` and the `cameras.bin` beside it.
/// @throws IoError naming the images there are, or the lens model that is not read.
[[nodiscard]] CameraParameters read_colmap_binary(const std::filesystem::path& folder, const std::string& image);

}  // namespace patinate
