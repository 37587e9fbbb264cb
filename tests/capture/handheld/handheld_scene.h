/// \file
/// Photographs of a known history as from the hand: turned, scaled, cropped, tinted, re-exposed, with their truth.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::testing_support {

struct HandheldScene {
  double largest_turn_deg = 180.0;  ///< Either way.
  double least_scale = 0.7;         ///< Photograph's pixels for one of the frames.
  double largest_scale = 1.5;
  double least_crop = 0.7;     ///< Share of the frame's sides that a photograph shows.
  double largest_tilt = 0.0;   ///< Change of scale from one side of a photograph to the other, by perspective.
  double largest_tint = 0.0;   ///< Natural logarithm of a channel's gain.
  double largest_stops = 0.0;  ///< Stops of exposure, either way; not saturated by more than the frame is.
  double noise = 0.004;        ///< Standard deviation, of 8-bit codes / 255.
  std::uint32_t seed = 1;
};

/// Result for one photograph.
struct HandheldPhoto {
  Eigen::Matrix3d photo_from_frame = Eigen::Matrix3d::Identity();  ///< Pixel centers.
  std::array<double, 3> gain{1.0, 1.0, 1.0};
  int width = 0, height = 0;
};

/// Draws photograph `index` of a frame of this size. Photograph 0 shows the whole frame, as it is.
[[nodiscard]] HandheldPhoto draw_photo(const HandheldScene& scene, int index, int width, int height);
/// Takes it: 8 x 8 bilinear samples a pixel; light 1 and more is code 255.
[[nodiscard]] ImageF take_photo(const ImageF& frame, const HandheldPhoto& photo, const HandheldScene& scene, int index);

/// Writes `photos/000.png` ... and `capture.json` with `more_json` in it ("\"align\": \"features\", ").
[[nodiscard]] std::vector<HandheldPhoto> write_handheld(const std::vector<ImageF>& frames, const HandheldScene& scene,
                                                        const std::filesystem::path& folder,
                                                        const std::string& more_json);

/// Root mean square distance, in the reference's pixels, of where two transforms bring a grid of the photograph's
/// pixels.
[[nodiscard]] double transform_error_px(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, int width, int height);

}  // namespace patinate::testing_support
