/// \file
/// Details by which photographs of one object are recognized, however they are turned, scaled and cropped.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Side to which larger photographs are reduced before details are looked for, in pixels.
inline constexpr int kFeatureSide = 1600;
/// Numbers that describe one detail.
inline constexpr int kFeatureNumbers = 128;

struct PhotoFeatures {
  int width = 0;  ///< Width of the photograph.
  int height = 0;
  double scale = 1.0;                     ///< Pixels in which details were looked for, for one of the photograph; <= 1.
  std::vector<Eigen::Vector2d> points;    ///< Pixels of the photograph; pixel centers are whole numbers.
  std::vector<std::uint8_t> descriptors;  ///< kFeatureNumbers a point.
  ImageU8
      evened;     ///< Picture that details were searched in: 128 = the local mean, 32 codes a local standard deviation.
  ImageU8 shown;  ///< Likewise reduced: 0 where nothing of the object is; may be empty.
};

/// SIFT features [Lowe 2004] of the encoded luminance over its local mean and strength, so that exposure, tint and
/// uneven light change little; descriptors as square roots [Arandjelovic and Zisserman 2012]. At most 3000, the
/// strongest.
/// @param color  H x W x 3, linear, finite. @param shown  0 where nothing of the object is; may be empty.
[[nodiscard]] PhotoFeatures find_features(const ImageF& color, const ImageU8& shown);

/// Details that both photographs have: pairs of indices (a, b) that are nearest to one another, clearly (Lowe's test).
[[nodiscard]] std::vector<std::pair<int, int>> match_features(const PhotoFeatures& a, const PhotoFeatures& b);

}  // namespace patinate::capture
