/// The share of light that reaches a place: by its orientation, from the sky and from the sun, with shadows.
#pragma once

#include <array>

#include "patinate/controls/control_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Settings of facing_map().
struct FacingOptions {
  std::array<double, 3> direction{
      0.0, 1.0, 0.0};  ///< From the surface to where it comes from; any length > 0. Default: up in glTF.
};
void describe(OptionVisitor& visitor, FacingOptions& options);

/// max(0, n . d) with the shading normal n: the cosine law; what faces away gets nothing and is 0. Range [0, 1]
/// "cosine". Shadows are not looked at.
/// @throws InvalidInput if the direction has no length.
[[nodiscard]] ControlMap facing_map(const TexelMap& map, const FacingOptions& options = {},
                                    const RunControl& control = {});

/// Settings of sun_map().
struct SunOptions {
  std::array<double, 3> direction{0.4, 0.8, 0.45};  ///< From the surface to the sun (at noon); any length > 0.
  double radius_deg = 0.27;  ///< Half angle of the disc; [0, 45]. The real sun: 0.27. 0 gives hard shadows.
  double arc_deg =
      0.0;  ///< The sun's way over the sky, half before and half after noon; [0, 180]. 0 = it stands still.
};
void describe(OptionVisitor& visitor, SunOptions& options);

/// Settings of exposure_map().
struct ExposureOptions {
  int num_rays = 256;      ///< Directions over the half of the sky; [16, 4096].
  double sun_share = 0.0;  ///< Share of the light that the sun gives, the sky gives the rest; [0, 1].
};
void describe(OptionVisitor& visitor, ExposureOptions& options);

/// The share of the sky's light that arrives, cosine-weighted: (1/pi) times the integral of V(w) max(0, n . w) over the
/// half sphere about `up`, V = 0 where the object is in the way [Miller 1994, "ambient light"; ambient occlusion under
/// an even sky]. A free surface that faces up gets 1, a free wall 1/2, one that faces down 0. With `sun_share` s: (1 -
/// s) sky + s sun, the sun as in sun_map(). Range [0, 1] "share"; with a panorama up to the greatest value, at least 1.
/// @param up        Middle of the sky; any length > 0.
/// @param panorama  Empty for an even sky; else its light over the whole sphere (panorama_sky()).
/// @throws InvalidInput if a direction has no length, an option is out of range, or the panorama brings no light.
/// Cost: a 1k atlas takes about 10 s on two cores with 256 rays. Same bits for any number of threads.
[[nodiscard]] ControlMap exposure_map(const TexelMap& map, const std::array<double, 3>& up = {0, 1, 0},
                                      const ExposureOptions& options = {}, const SunOptions& sun = {},
                                      const ImageF& panorama = {}, const RunControl& control = {});

/// max(0, n . s) where the sun is seen, the mean over its disc and its way: the sun turns about an axis that is
/// perpendicular to its noon direction, rising and setting where that direction's level perpendicular points (the day
/// of an equinox, when `arc_deg` is 180). Range [0, 1] "cosine".
/// @throws InvalidInput if a direction has no length or an option is out of range. Cost: 64 rays a texel, 1 for a point
/// sun that stands still. Same bits for any number of threads.
[[nodiscard]] ControlMap sun_map(const TexelMap& map, const std::array<double, 3>& up = {0, 1, 0},
                                 const SunOptions& options = {}, const RunControl& control = {});

}  // namespace patinate
