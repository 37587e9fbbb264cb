/// \file
/// A scan as registration works on it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "capture/registration/surfel_alignment.h"
#include "patinate/capture/registration.h"
#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

/// Depths of a scan as its scanner saw them, in square cells across the lines of sight.
class LinesOfSight {
 public:
  /// @param scanner         Where it stood; or nothing, and then
  /// @param toward_scanner  unit, the same for all points. @param cell  > 0, at least the points' spacing.
  LinesOfSight(std::span<const Vec3> points, const std::optional<Vec3>& scanner, const Vec3& toward_scanner,
               double cell);

  enum class Seen { Nothing, Front, Surface, Behind };
  /// Where a point lies with respect to what was seen in its cell and the 8 around: nothing was seen in its cell; in
  /// front of all of it by more than `tolerance`; behind all of it by more; or on it.
  [[nodiscard]] Seen look_at(const Vec3& p, double tolerance) const;

 private:
  struct Depths {
    double nearest;  ///< Towards the scanner.
    double farthest;
  };
  [[nodiscard]] Vec3 across_and_depth(const Vec3& p) const;
  [[nodiscard]] static std::uint64_t key(std::int64_t x, std::int64_t y) {
    return (static_cast<std::uint64_t>(x) << 32) ^ (static_cast<std::uint64_t>(y) & 0xFFFFFFFFu);
  }
  std::optional<Vec3> scanner_;
  Vec3 u_, v_, w_;       ///< w towards the scanner.
  double distance_ = 1;  ///< Distance of the middle of the points from the scanner.
  double cell_;
  std::unordered_map<std::uint64_t, Depths> cells_;
};

/// Counts of what one scan's points are in the other's lines of sight.
struct SightCounts {
  int front = 0;
  int surface = 0;
  void add(const LinesOfSight& lines, std::span<const Vec3> points, const RigidTransform& lines_from_points,
           double tolerance, std::size_t stride);
};

/// Coordinates are normalized: about the scan's middle, in the scans' common scale.
class PreparedScan {
 public:
  /// @param fine_distance  Normalized, between fine surfels.
  PreparedScan(const PointCloud& cloud, double scale, double fine_distance, const RunControl& control);

  [[nodiscard]] const SurfelSet& fine() const { return *fine_; }
  [[nodiscard]] const SurfelSet& coarse() const { return *coarse_; }
  /// Absent when it is not known where the scanner stood.
  [[nodiscard]] const LinesOfSight* lines_of_sight() const { return lines_.get(); }
  /// Positions of fine(), for look-ups in lines of sight.
  [[nodiscard]] const std::vector<Vec3>& positions() const { return *positions_; }
  [[nodiscard]] const Vec3& middle() const { return middle_; }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double surface_share() const {
    return surface_share_;
  }  ///< Share of the places where a fine surfel was looked for.
  /// Points per fine surfel.
  [[nodiscard]] double points_per_surfel() const { return points_per_surfel_; }

 private:
  Vec3 middle_ = Vec3::Zero();
  double scale_;
  double points_per_surfel_ = 1.0;
  double surface_share_ = 0.0;
  std::shared_ptr<const SurfelSet> fine_, coarse_;
  std::shared_ptr<const LinesOfSight> lines_;
  std::shared_ptr<const std::vector<Vec3>> positions_;
};

/// All scans that will be registered with each other: they share scale and spacing.
/// @throws InvalidInput naming the scan's index if one has fewer than 16 points, no extent, or no surface.
[[nodiscard]] std::vector<PreparedScan> prepare_scans(std::span<const PointCloud> scans,
                                                      const RegistrationOptions& options,
                                                      const RunControl& control = {});
/// Works as register_pair() of clouds (registration.h).
[[nodiscard]] PairRegistration register_pair(const PreparedScan& target, const PreparedScan& source,
                                             const std::optional<RigidTransform>& start,
                                             const RegistrationOptions& options = {}, const RunControl& control = {});

/// Judges a pose that came from elsewhere, as register_pair() does; the pose stays as it is (num_iterations 0).
[[nodiscard]] PairRegistration judge_pose(const PreparedScan& target, const PreparedScan& source,
                                          const RigidTransform& target_from_source,
                                          const RegistrationOptions& options = {}, const RunControl& control = {});
/// Normal equations of the full stage in a pose (normalized): how the pair alone would continue from there.
[[nodiscard]] SurfelAlignment look_at_pose(const PreparedScan& target, const PreparedScan& source,
                                           const RigidTransform& pose, const RunControl& control = {});
/// The information that goes with a PairRegistration's covariance, about the origins of the normalized frames; free
/// directions have 0.
[[nodiscard]] Matrix6 information_of(const SurfelAlignment& alignment, const PreparedScan& target,
                                     const PreparedScan& source);

/// Unconstrained degrees of freedom in normalized coordinates in the target's own frame.
[[nodiscard]] std::vector<UnconstrainedDof> in_frame(std::vector<UnconstrainedDof> motions, const PreparedScan& target);

inline constexpr double kCoarseDistance =
    0.12;  ///< Distance of coarse surfels, normalized: a tenth of the object's size or so.

/// x_in_cloud = middle + scale * x_normalized on both sides.
[[nodiscard]] RigidTransform normalized(const RigidTransform& target_from_source, const PreparedScan& target,
                                        const PreparedScan& source);
[[nodiscard]] RigidTransform in_unit(const RigidTransform& pose, const PreparedScan& target,
                                     const PreparedScan& source);

/// Share of the surface seen by both scans in a pose (normalized) that lies in the other scanner's lines of sight
/// by more than `tolerance`; nothing when neither scan says where its scanner stood. @param num_looked  About so many
/// surfels of either scan are looked at; > 0.
[[nodiscard]] std::optional<double> share_in_front(const PreparedScan& target, const PreparedScan& source,
                                                   const RigidTransform& pose, double tolerance, int num_looked);
/// Share of the smaller scan's surfels that found partners.
[[nodiscard]] double overlap_of(const PairSums& sums);

}  // namespace patinate::capture
