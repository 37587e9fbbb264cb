/// \file
/// Mirror spheres and what a camera sees of them, by formulas of their own: the truth for lights from spheres.
#pragma once

#include <vector>

#include "libcommon/core/random.h"
#include "patinate/capture/sphere_lights.h"

namespace patinate::testing_support {

struct MirrorScene {
  Camera camera;
  std::vector<Vec3> centers;
  double radius_mm;
};
/// Four spheres of radius 40 mm on a table of 240 mm x 160 mm, 600 mm from a camera of 2448 x 2048 pixels (0.25 mm a
/// pixel) that is tilted and has a lens that distorts.
[[nodiscard]] MirrorScene four_spheres();

/// Where a light (a position, or a direction when `is_distant`) is seen in a sphere: bisection along the arc between
/// camera and light.
[[nodiscard]] Vec2 highlight_of(const Camera& camera, const Vec3& center, double radius_mm, const Vec3& light,
                                bool is_distant = false);
/// Points where rays touch the sphere, each as far as sigma_px from where it is seen.
[[nodiscard]] std::vector<Vec2> outline_of(const Camera& camera, const Vec3& center, double radius_mm, int count,
                                           double sigma_px, RandomStream& random);
/// The spheres with their outlines.
[[nodiscard]] std::vector<capture::MirrorSphere> spheres_of(const MirrorScene& scene, int count, double sigma_px,
                                                            RandomStream& random);

/// A photograph by ray tracing, 3 x 3 rays a pixel: a ball of light mirrored in the spheres above a dim floor and sky,
/// and noise.
[[nodiscard]] ImageF photograph_of(const MirrorScene& scene, const std::vector<Vec3>& lights, double light_radius_mm,
                                   double noise, std::uint64_t seed);

}  // namespace patinate::testing_support
