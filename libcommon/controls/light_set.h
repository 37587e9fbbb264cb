/// \file
/// Skies and suns as a fixed list of directions, the same for every surface point, so that maps carry no noise.
#pragma once

#include <vector>

#include "libcommon/controls/smooth_surface.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate {

/// Distant lights: a free surface with normal n gets sum_i weight_i max(0, n . direction_i).
struct LightSet {
  std::vector<Vec3> directions;  ///< Unit, from the surface; neighbors in the list are neighbors in the sky.
  std::vector<double> weights;   ///< Weight of each direction; >= 0.
  /// Light that a free surface with unit normal `n` gets.
  [[nodiscard]] double free_light(const Vec3& n) const;
};

/// `num` directions spread evenly over the sphere (Fibonacci lattice), each of weight 1.
[[nodiscard]] LightSet even_sphere(int num);
/// The half of even_sphere(2 num) about `up`, weighted so that a free surface that faces up gets 1.
[[nodiscard]] LightSet even_sky(const Vec3& up, int num);
/// A panorama as light: the light of each of its pixels goes to the nearest of even_sphere(2 num), which moves to the
/// mean direction of its light, so that a small bright sun stays where it is. Weighted so that a free surface that
/// faces up gets 1.
/// @param panorama  H x W, linear, >= 0: equirectangular, top row up, middle column towards -z and right of it +x (y
/// up);
///                  another `up` turns it along.
/// @throws InvalidInput if no light reaches a surface that faces up.
[[nodiscard]] LightSet panorama_sky(const Vec3& up, int num, const ImageF& panorama);

/// Light that every texel gets, each light shadowed by what lies within `reach_mm` (1e30 = anything).
/// @param share_of_free  Give the blocked share, sum(w cos blocked) / sum(w cos), in place of the light.
/// Cost: one ray for each texel and light above its horizon. Same bits for any number of threads.
[[nodiscard]] ImageF shadowed_light(const SmoothSurface& surface, const LightSet& lights, double reach_mm,
                                    bool share_of_free, const RunControl& control);

/// SmoothSurface for rays: edges of at most 1 % of the box's diagonal, at most 400,000 triangles.
[[nodiscard]] SmoothSurface surface_for_rays(const TexelMap& map, const RunControl& control);

}  // namespace patinate
