/// \file
/// What else changed between two photographs once one is laid over the other: exposure, and the surface itself.
#pragma once

#include <array>

#include "capture/stability/frame_motion.h"
#include "capture/stability/light_change.h"

namespace patinate::capture {

struct FrameChange {
  std::array<double, 3>
      log_gain{};        ///< Natural logarithm of frame / reference, per channel: the median over the picture.
  LightChange light;     ///< What of it is the light's: measured on places of 4 x 4 pixels of the coarse light.
  double surface = 0.0;  ///< Mean distance of sRGB codes in [0, 1] that is left when the gain is taken out.
};

/// Compares the coarse light of both frames where they overlap: a change of exposure moves every ratio alike, so the
/// median ratio is it, as long as less than half of the surface changes more than the rest. What is near black or
/// saturated does not count.
/// @throws InvalidInput if sizes differ.
[[nodiscard]] FrameChange measure_change(const PreparedFrame& reference, const PreparedFrame& frame,
                                         const Eigen::Affine2d& frame_from_reference);

}  // namespace patinate::capture
