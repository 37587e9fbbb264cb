/// \file
/// A scan as small flat pieces of surface: where, which way they face, how well they are known. What registration works
/// on.
#pragma once

#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/geometry/point_cloud.h"

namespace patinate::capture {

/// Median distance to the neighbor points of a surface, as if they lay on a square lattice: 0.627 times the distance to
/// the 8th nearest, over a sample of the points. @throws InvalidInput if there are less than 16 points, or they have no
/// extent.
[[nodiscard]] double point_spacing(std::span<const Vec3> points);

/// One flat piece.
struct Surfel {
  Vec3 position;      ///< On the plane fitted to the points around.
  Vec3 normal;        ///< Unit; towards the scanner when that is known, else in no particular sense.
  double variance;    ///< Variance of the points around off the plane; > 0.
  double num_points;  ///< Effective number that the plane was fitted to (weights that sum to 1, squared and summed,
                      ///< inverted).
  int point;          ///< Point of the scan: the one it was made around.
  bool is_border;     ///< Its points lie to one side: the scan ends here. Never used as a partner.
};

struct Surfels {
  std::vector<Surfel> surfels;
  int num_places = 0;  ///< Where one was looked for.
};

/// Surfels at least `distance` apart (greedily, in the order of the points), each the plane through the points within
/// `radius`, weighted by 1 - (d / radius)^2. Places where the points are no surface (fewer than 6, or as thick as wide)
/// are excluded.
/// @param toward  To the scanner, per point; empty = not known.
/// Moving all points moves the surfels alike, to rounding. Same bits for any number of threads.
[[nodiscard]] Surfels make_surfels(std::span<const Vec3> points, std::span<const Vec3> toward, double distance,
                                   double radius, const RunControl& control = {});

}  // namespace patinate::capture
