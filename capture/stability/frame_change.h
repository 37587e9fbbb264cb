/// \file
/// What else changed between two photographs once one is laid over the other: exposure, and the surface itself.
#pragma once

#include <array>
#include <vector>

#include "capture/stability/frame_motion.h"

namespace patinate::capture {

/// Share of the places that makes a large gain the light's. Aging shares one less: at most 0.62 on the copper, salt and
/// melon of docs/algorithms/stability.md, while photographs of them that were tinted share 0.76 and more.
inline constexpr double kSharedByMost = 0.7;

/// The change of light from one photograph to another.
struct LightChange {
  std::array<double, 3> log_gain{};  ///< Natural logarithm of frame / reference: red, green, blue.
  double share =
      0.0;  ///< Share of the places, [0, 1]: whose ratios lie within `width`, or half the gain's own size, of it.
  double width =
      0.0;  ///< Width of the window around the gain that a quarter of the places share; 0 = nothing was compared.

  /// Largest size of log_gain over the channels.
  [[nodiscard]] double size() const;
  /// Whether the change is the light's: a small one (twice the narrowest window) that a quarter of the places share
  /// sharply, or one that most places share to within half of itself. Aging differs more from place to place.
  [[nodiscard]] bool is_sure() const;
};

/// The mode of the log ratios in all three channels at once: when the light changes, every place that does not age has
/// exactly its gain, while aging spreads the ratios. The window is the narrowest of 0.04, 0.08, 0.16 and 0.32 that
/// holds a quarter of the places. The light is taken as unchanged where a gain of 1 is shared by half as many places as
/// the commonest gain elsewhere: they cannot have stayed as they were when the light changed.
/// @param log_ratios  Of each place, red, green, blue; finite. May be empty: width 0, not sure.
[[nodiscard]] LightChange find_light_change(const std::vector<std::array<double, 3>>& log_ratios);

struct FrameChange {
  std::array<double, 3>
      log_gain{};        ///< Natural logarithm of frame / reference, per channel: the median over the picture.
  LightChange light;     ///< Part of it that is the light's: measured on places of 4 x 4 pixels of the coarse light.
  double surface = 0.0;  ///< Mean distance of sRGB codes in [0, 1] that is left when the gain is taken out.
};

/// Compares the coarse light of both frames where they overlap: a change of exposure moves every ratio alike, so the
/// median ratio is it, as long as less than half of the surface changes more than the rest. What is near black or
/// saturated does not count.
/// @throws InvalidInput if sizes differ.
[[nodiscard]] FrameChange measure_change(const PreparedFrame& reference, const PreparedFrame& frame,
                                         const Eigen::Affine2d& frame_from_reference);

}  // namespace patinate::capture
