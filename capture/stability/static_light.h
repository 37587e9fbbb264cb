/// \file
/// A near lamp's light and its reflection, which stay in place while the surface ages.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::capture {

/// A place of the picture: (0, 0) its middle, the longer side from -1 to 1.
struct PicturePoint {
  double x = 0.0, y = 0.0;
};

/// Light of a near lamp on a flat surface, 1 / (1 + r^2 / h^2)^(3/2) at r from the place below it, h above it.
struct LampLight {
  PicturePoint below;
  double inverse_height2 = 0.0;  ///< 1 / h^2; > 0.
  [[nodiscard]] double at(const PicturePoint& p) const;
};

/// The reflection of a lamp in a rough surface, strength / (1 + r^2 / w^2)^2 at r from its middle.
struct LampReflection {
  PicturePoint middle;
  double inverse_width2 = 0.0;  ///< 1 / w^2; > 0.
  double strength = 0.0;        ///< Linear light, the same in all channels.
  [[nodiscard]] double at(const PicturePoint& p) const;
};

/// Light that stays in the picture while the surface changes: photograph = lamp * albedo + reflection.
struct StaticLight {
  std::optional<LampLight> lamp;
  std::optional<LampReflection> reflection;
  double ratio = 1.0;  ///< Ratio of the lamp over what is inside the mask, without the 2 % at either end; >= 1.
  double mean = 1.0;   ///< Mean of the lamp there: albedo keeps the photographs' brightness.
  [[nodiscard]] bool is_any() const { return lamp || reflection; }
};

/// Fits lamp and reflection to the means of 12 x 12 windows of all frames and channels at once, each frame and channel
/// with a color of its own that is the same all over: seven numbers for the light, so that a surface's own pattern can
/// hardly be taken for it.
///
/// Both are believed only where the series shows it:
/// - the surface was replaced (is_surface_replaced(), of the frames or of what is left of them without the light);
/// - the lamp's ratio is kUnevenRatio or more; it explains 0.3 of the variance of the windows' logarithms; fits to the
///   first and to the second half of the frames agree (0.7, by 1 - variance of the difference / sum of the variances of
///   its logarithm);
/// - fits of the reflection agree likewise (0.9: it is fitted to what the lamp leaves); its middle lies inside, adds
///   0.05 of the picture's light, and is wider than a window; nowhere is it more than the light itself, but for one
///   sample in 1,000.
/// @param frames  As find_uneven_light() has them. Six or more, of 48 px or more, or nothing is found. @param mask  May
/// be empty.
/// @throws InvalidInput if sizes differ.
[[nodiscard]] StaticLight find_static_light(const std::vector<ImageF>& frames, const ImageU8& mask);

/// Removes the light: (photograph - reflection) / lamp * its mean, at least 0.
void take_light_out(ImageF& photograph, const StaticLight& light);

}  // namespace patinate::capture
