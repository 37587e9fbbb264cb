/// \file
/// A textured surface on which bright things grow, seen by a camera that can be moved, with known truth.
#pragma once

#include <Eigen/Geometry>

#include "patinate/image/image.h"

namespace patinate::testing_support {

struct StabilityScene {
  int size = 192;
  double growth = 0.0;  ///< [0, 1]. Share of the final radius of what grows.
  double exposure = 1.0;
  Eigen::Affine2d frame_from_scene = Eigen::Affine2d::Identity();
};

/// size x size x 3, linear, evaluated at exact positions: a shift needs no interpolation.
[[nodiscard]] ImageF render_scene(const StabilityScene& scene);

}  // namespace patinate::testing_support
