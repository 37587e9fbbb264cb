/// \file
/// Two scans of one object, brought into one frame; and what their shape leaves open.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/geometry/point_cloud.h"
#include "patinate/geometry/rigid_transform.h"

namespace patinate::capture {

enum class RegistrationMethod { Symmetric, PclPlane, PclPoint, PclGicp };
inline constexpr std::array<std::string_view, 4> kRegistrationMethodNames{"symmetric", "pcl-plane", "pcl-point",
                                                                          "pcl-gicp"};
enum class RegistrationStart { Auto, Given, Global };
inline constexpr std::array<std::string_view, 3> kRegistrationStartNames{"auto", "given", "global"};

/// Settings of register_pair() and of all that stands on it.
struct RegistrationOptions {
  RegistrationMethod method = RegistrationMethod::Symmetric;
  RegistrationStart start =
      RegistrationStart::Auto;  ///< Auto: from the start that is given, and by search where that fails.
  double min_overlap = 0.15;    ///< Share of the smaller scan that must find partners; (0, 1].
  double max_in_front = 0.06;   ///< Share of what both see that may lie in the other scanner's line of sight; [0, 1].
  int max_iterations = 60;      ///< Iterations of the last, full stage; > 0.
  int max_surfels = 60000;      ///< A scan is thinned to about so many pieces; [100, 10^7].
};
void describe(OptionVisitor& v, RegistrationOptions& o);

enum class RegistrationStatus { Converged, IterationLimit, TooFewPairs, Degenerate, PoorFit };
/// "converged", "iteration limit", ...
[[nodiscard]] std::string_view name_of(RegistrationStatus status);
/// Says whether a registration with this status has a pose.
[[nodiscard]] constexpr bool is_found(RegistrationStatus status) {
  return status == RegistrationStatus::Converged || status == RegistrationStatus::Degenerate;
}

/// A degree of freedom that the shape does not constrain, because the surface slides along itself: a rigid motion that
/// changes nothing.
struct UnconstrainedDof {
  enum class Kind { Shift, Turn };
  Kind kind = Kind::Shift;
  Vec3 direction = Vec3(0, 0, 1);  ///< Unit: of the shift, or of the turn's axis.
  Vec3 point = Vec3::Zero();       ///< Turn: on the axis, the one nearest to the origin of the frame.
  double pitch = 0.0;              ///< Turn: shift along the axis per radian; 0 but for screws.
};
/// "shift along (0, 0, 1)", "turn about (0, 0, 1) through (10, 2, 0)".
[[nodiscard]] std::string text_of(const UnconstrainedDof& motion);

/// What register_pair() found; lengths in the scans' unit.
struct PairRegistration {
  RegistrationStatus status = RegistrationStatus::TooFewPairs;
  RigidTransform target_from_source;
  double rms_residual =
      0.0;  ///< Root mean square of the distances of partners along their normals, weighted as in the fit.
  double median_residual = 0.0;  ///< Median of the same, absolute, over all partners, those that do not fit too.
  double overlap = 0.0;          ///< Share of the smaller scan's surface that has a partner; [0, 1].
  double fitting = 0.0;  ///< Share of the partners that fit; the others lie as near, but as surfaces that changed, or
                         ///< in a wrong pose.
  std::optional<double> in_front;  ///< Share of the surface seen by both scans that one scan puts in front of the
                                   ///< other's; absent without lines of sight.
  /// Of (rotation in radians, shift) about `center` in the target's frame, from the scatter of the points;
  /// unconstrained degrees of freedom are excluded from it. Errors that are common to many points of a scan (its
  /// scanner's calibration) are not in it.
  Matrix6 covariance = Matrix6::Zero();
  Vec3 center = Vec3::Zero();  ///< Middle of the target scan.
  /// Share of the partners that lie no farther apart than the points' own scatter makes them, [0, 1]: where it is
  /// small, most of the surface has changed.
  double staying = 1.0;
  /// Displacement of the pose, as in `covariance`, if the changed share were misjudged (changed_surface.h); 0 for a
  /// stable surface.
  Vec6 misjudged = Vec6::Zero();
  std::vector<UnconstrainedDof> unconstrained_dofs;  ///< Unconstrained degrees of freedom, held at their starting
                                                     ///< values; the status is then Degenerate.
  int num_pairs = 0;
  int num_iterations = 0;
  bool is_found_by_search = false;
  /// Degrees by which another pose turns that fits nearly as well; 0 = none was found, or the start was near enough.
  double ambiguous_deg = 0.0;
};

/// Symmetric generalized ICP in double precision, recentered and rescaled (surfel_alignment.h), from `start`, else from
/// a search over rotations (rotation_search.h). The status is Converged only when enough of the smaller scan finds
/// partners, they fit as the scans' noise and spacing allow, and neither scan lies in the other scanner's lines of
/// sight. Not reaching it is a status, not an exception. Swapped scans give the inverse; neither unit nor origin
/// matter. Same bits for any number of threads.
/// @param start  target from source; nothing = search, whatever options.start says.
/// @throws InvalidInput on options out of range, a scan of fewer than 16 points or without extent or surface, or a
/// method other than Symmetric (see reference_methods.h); Canceled.
[[nodiscard]] PairRegistration register_pair(const PointCloud& target, const PointCloud& source,
                                             const std::optional<RigidTransform>& start,
                                             const RegistrationOptions& options = {}, const RunControl& control = {});

}  // namespace patinate::capture
