/// \file
/// What is behind the object.
#pragma once

#include <cmath>

#include "patinate/output/render.h"

namespace patinate {

/// The studio's backdrop as a function of the place in the picture, [0, 1] each.
[[nodiscard]] inline float backdrop(const RenderOptions& o, double u, double v) {
  if (o.backdrop == Backdrop::White) return 1.0f;
  const double dx = u - 0.5, dy = v - 0.58;
  const double fall = std::exp(-1.4 * (dx * dx + 1.2 * dy * dy));
  return static_cast<float>(o.background * (0.45 + 0.55 * fall));
}

}  // namespace patinate
