/// \file
/// Two scans as surfels, brought together from a start nearby: symmetric generalized ICP.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "capture/registration/surfels.h"
#include "libcommon/geometry/nearest_points.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// Surfels of one scan with what finds the nearest of them. Lengths are in any unit; rotations are best about the
/// origin.
class SurfelSet {
 public:
  /// @param distance  The one the surfels were made with. @param is_oriented  Normals point towards the scanner.
  SurfelSet(std::vector<Surfel> surfels, double distance, bool is_oriented);

  [[nodiscard]] const std::vector<Surfel>& surfels() const { return surfels_; }
  [[nodiscard]] const Surfel& operator[](int i) const { return surfels_[i]; }
  [[nodiscard]] int size() const { return static_cast<int>(surfels_.size()); }
  [[nodiscard]] double distance() const { return distance_; }
  [[nodiscard]] bool is_oriented() const { return is_oriented_; }
  [[nodiscard]] double median_variance() const { return median_variance_; }
  struct Found {
    int index = -1;       ///< -1 = none.
    double margin = 0.0;  ///< So far may p move with the same surfel staying the nearest; 0 = not known.
  };
  /// The nearest within `radius`. @param hint  A surfel that is likely near, or -1: makes it faster, never another.
  [[nodiscard]] Found nearest(const Vec3& p, double radius, int hint) const;

 private:
  std::vector<Surfel> surfels_;
  double distance_;
  bool is_oriented_;
  double median_variance_;
  std::shared_ptr<const NearestPoints> points_;
};

/// How far partners may lie apart while the scans are brought together.
struct AlignmentSchedule {
  double first_gate = 0.0;     ///< In the surfels' unit; > 0.
  double last_gate = 0.0;      ///< > 0.
  int stride = 1;              ///< Every so-many-th surfel looks for a partner; > 0.
  int max_iterations = 60;     ///< > 0.
  bool narrows_scale = false;  ///< Looks for a fit that leaves a changed part out, too.
  double step = 0.0;           ///< Ends when neither a point nor a normal moves by more, with the last gate.
};

/// The last step's normal equations and what they were made of.
struct PairSums {
  Matrix6 information =
      Matrix6::Zero();  ///< Sum of w J J^T, J = (m x n, n), m = the partners' middle in the target's frame.
  Matrix6 crossed = Matrix6::Zero();  ///< Information with either partner's own normal on either side, symmetrized:
                                      ///< noise of normals drops out.
  Vec6 gradient = Vec6::Zero();       ///< Sum of w r J.
  double weight = 0.0;                ///< Sum of w.
  double weighted_squares = 0.0;      ///< Sum of w r^2.
  int num_pairs = 0;                  ///< With w > 0.
  std::array<int, 2> num_looked{};    ///< Surfels of source and target that looked for a partner,
  std::array<int, 2> num_found{};     ///< and that found one within the gate, facing alike.
  std::array<int, 2> num_fitting{};   ///< Number of those with a residual that counts.
  double variance =
      0.0;  ///< Sum of w (variance / num_points) of both partners: of r, were the noise that of the points.
  void add(const PairSums& other);
};

/// Result of align_surfels().
struct SurfelAlignment {
  RigidTransform target_from_source;
  PairSums sums;
  double residual_scale = 0.0;   ///< Robust standard deviation of r.
  double median_residual = 0.0;  ///< Median residual of |r|, over all partners.
  double gate = 0.0;
  double last_step = 0.0;
  int num_iterations = 0;
  int num_held = 0;  ///< Directions that the last step did not move in, as nothing determines them.
};

/// Gauss-Newton on sum w r^2, r = (p - q) . n, n along the sum of both partners' normals [Rusinkiewicz 2019], partners
/// being the nearest in either direction. w: Tukey's of r (4.7 robust standard deviations, by the lower quartile of
/// |r|), fading with the distance of the partners and with the angle between their normals, over the sum of their
/// variances [Segal 2009]. Directions with less than kFreeShare of the largest eigenvalue of the information are held.
/// Swapped sets give the inverse to rounding. Same bits for any number of threads.
[[nodiscard]] SurfelAlignment align_surfels(const SurfelSet& target, const SurfelSet& source,
                                            const RigidTransform& start, const AlignmentSchedule& schedule,
                                            const RunControl& control = {});

inline constexpr double kFreeShare = 1e-3;  ///< See docs/algorithms/registration.md.

}  // namespace patinate::capture
