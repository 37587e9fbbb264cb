#include "patinate/capture/registration.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/registration/changed_surface.h"
#include "capture/registration/prepared_scan.h"
#include "capture/registration/rotation_search.h"
#include "capture/registration/unconstrained_dof.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::capture {

void describe(OptionVisitor& v, RegistrationOptions& o) {
  v.visit_choice({"method", "How two scans are brought together; pcl-... are PCL's own, for comparison"}, o.method,
                 kRegistrationMethodNames);
  v.visit_choice(
      {"start", "auto: from the given poses, and by search where that fails; given; global: by search alone"}, o.start,
      kRegistrationStartNames);
  v.visit({"min_overlap",
           "Share of the smaller scan that must find partners",
           "",
           {.low = 0, .high = 1, .is_low_open = true}},
          o.min_overlap);
  v.visit({"max_in_front",
           "Largest share of the surface seen by both scans that may block the other scanner's line of sight", "",
           between(0, 1)},
          o.max_in_front);
  v.visit({"max_iterations", "Of the last, full stage", "", between(1, 10000)}, o.max_iterations);
  v.visit({"max_surfels", "Approximate number of surface elements that a scan is reduced to", "", between(100, 1e7)},
          o.max_surfels);
}

std::string_view name_of(RegistrationStatus status) {
  constexpr std::array<std::string_view, 5> kNames{"converged", "iteration limit", "too few pairs", "degenerate",
                                                   "poor fit"};
  return kNames[static_cast<std::size_t>(status)];
}

namespace {

constexpr int kNumCandidates = 16;  ///< Best different candidates (docs/algorithms/registration.md).
constexpr int kMidIterations = 40;  ///< Iterations of the middle stage.
constexpr int kMidSurfels = 2500;   ///< That look for partners in the middle stage, of either scan.
/// Surfels that candidates are compared on (docs/algorithms/registration.md).
constexpr int kCandidateSurfels = 800, kCandidateIterations = 15;
constexpr int kNearlyStride = 4;            ///< The last stage begins with every fourth surfel.
constexpr double kLastGate = 1.5;           ///< In fine distances,
constexpr double kLastGateScales = 6.0;     ///< or residual scales, where the scans fit worse than that.
constexpr double kConvergedStep = 1e-3;     ///< In fine distances: what Converged promises.
constexpr double kFixedStep = 1e-8;         ///< Normalized: nothing moves any more.
constexpr double kMaxResidual = 0.25;       ///< Residual scale in fine distances above which it is no fit,
constexpr double kMaxScatter = 6.0;         ///< unless the points' own scatter makes so much of it.
constexpr int kLookedInFrontOfPose = 3000;  ///< Points whose lines of sight are checked, evenly picked.
/// Tolerances in the residuals' scale and in spacings (docs/algorithms/registration.md).
constexpr double kSightScales = 5.0, kSightDistance = 0.5;
constexpr double kSightDepth = 0.04;  ///< Normalized: growth and wear are less than that, a wrong pose is not.
constexpr double kFinalist = 0.7;     ///< Candidates are followed to the end if they score this share of the best one.
/// A pose is as likely as the best one if it overlaps as much, and if its shape adds no more to the residuals than they
/// are in the best one.
constexpr double kRivalOverlap = 0.9, kRivalScale = std::numbers::sqrt2;
constexpr double kSamePoseDeg = 2.0;  ///< Finalists nearer than this are one, which converged from two starts.
constexpr int kMinTrustedPairs = 30;  ///< Fewer pairs do not make a trusted pose.
constexpr double kCrossedShare =
    0.3;  ///< Share of a direction's information that must come from more than noise of normals.

/// How far in front counts: more than the fit's own scatter, than what a slope makes between the cells of lines of
/// sight, and than surfaces age.
double sight_tolerance(double residual_scale, double distance) {
  return std::max({kSightScales * residual_scale, kSightDistance * distance, kSightDepth});
}

/// One local alignment, to the end.
struct Local {
  SurfelAlignment alignment;
  std::optional<double> in_front;
};

/// @param is_candidate  One of many: with fewer surfels and steps.
SurfelAlignment align_middle(const PreparedScan& target, const PreparedScan& source, const RigidTransform& start,
                             bool is_candidate, const RunControl& control) {
  const double distance = target.fine().distance(), coarse = target.coarse().distance();
  const int stride = std::max(
      1, std::max(target.fine().size(), source.fine().size()) / (is_candidate ? kCandidateSurfels : kMidSurfels));
  return align_surfels(target.fine(), source.fine(), start,
                       {.first_gate = 2.0 * coarse,
                        .last_gate = 3.0 * distance,
                        .stride = stride,
                        .max_iterations = is_candidate ? kCandidateIterations : kMidIterations,
                        .narrows_scale = !is_candidate,
                        .step = kConvergedStep * distance},
                       control);
}

Local align_fully(const PreparedScan& target, const PreparedScan& source, const RigidTransform& start,
                  const RegistrationOptions& options, const RunControl& control) {
  const double distance = target.fine().distance(), coarse = target.coarse().distance();
  Local local;
  local.alignment = align_middle(target, source, start, false, control);
  const double last_gate =
      std::clamp(kLastGateScales * local.alignment.residual_scale, kLastGate * distance, 2.0 * coarse);
  local.alignment = align_surfels(target.fine(), source.fine(), local.alignment.target_from_source,
                                  {.first_gate = std::max(2.0 * last_gate, 3.0 * distance),
                                   .last_gate = last_gate,
                                   .stride = kNearlyStride,
                                   .max_iterations = kMidIterations,
                                   .step = kConvergedStep * distance},
                                  control);
  local.alignment = align_surfels(target.fine(), source.fine(), local.alignment.target_from_source,
                                  {.first_gate = last_gate,
                                   .last_gate = last_gate,
                                   .stride = 1,
                                   .max_iterations = options.max_iterations,
                                   .step = kFixedStep},
                                  control);
  local.in_front = share_in_front(target, source, local.alignment.target_from_source,
                                  sight_tolerance(local.alignment.residual_scale, distance), kLookedInFrontOfPose);
  return local;
}

/// Directions that the surface does not constrain: little information, or such as comes from noise of the normals
/// alone.
Eigen::Matrix<double, 6, Eigen::Dynamic> open_directions(const PairSums& sums) {
  const SymmetricEigen<Matrix6> solver = symmetric_eigen(sums.information);
  Eigen::Matrix<double, 6, Eigen::Dynamic> open(6, 0);
  for (int k = 0; k < 6; ++k) {
    const Vec6 direction = solver.vectors.col(k);
    const double value = solver.values[k];
    if (value > kFreeShare * solver.values[5] && direction.dot(sums.crossed * direction) > kCrossedShare * value)
      continue;
    open.conservativeResize(6, open.cols() + 1);
    open.col(open.cols() - 1) = direction;
  }
  return open;
}

/// How much a unit of PairSums::information counts, from the scatter of the points and how many there are: every point
/// counts in several surfels, so that these are no measurements of their own. Where the scans fit worse than their
/// scatter says, that counts.
double weight_of_information(const PairSums& sums, const PreparedScan& target, const PreparedScan& source) {
  const double num_points = 0.5 * sums.num_pairs * 0.5 * (target.points_per_surfel() + source.points_per_surfel());
  const double scatter = target.fine().median_variance() + source.fine().median_variance();
  const double misfit = std::max(1.0, sums.weighted_squares / sums.variance);
  return num_points / (sums.weight * scatter * misfit);
}

Matrix6 covariance_of(const PairSums& sums, const PreparedScan& target, const PreparedScan& source) {
  const SymmetricEigen<Matrix6> solver =
      symmetric_eigen(Matrix6(sums.information * weight_of_information(sums, target, source)));
  Matrix6 covariance = Matrix6::Zero();
  for (int k = 0; k < 6; ++k) {
    if (!(solver.values[k] > kFreeShare * solver.values[5])) continue;
    const Vec6 direction = solver.vectors.col(k);
    covariance += direction * direction.transpose() / solver.values[k];
  }
  Vec6 unit;
  unit << 1, 1, 1, target.scale(), target.scale(), target.scale();
  return unit.asDiagonal() * covariance * unit.asDiagonal();
}

}  // namespace

std::vector<UnconstrainedDof> in_frame(std::vector<UnconstrainedDof> motions, const PreparedScan& target) {
  for (UnconstrainedDof& m : motions) {
    m.point = target.middle() + target.scale() * m.point;
    m.point -= m.direction * m.direction.dot(m.point);
    m.pitch *= target.scale();
  }
  return motions;
}

namespace {

PairRegistration judge(const PreparedScan& target, const PreparedScan& source, const Local& local,
                       const RegistrationOptions& options) {
  const SurfelAlignment& a = local.alignment;
  PairRegistration r;
  r.target_from_source = in_unit(a.target_from_source, target, source);
  r.overlap = overlap_of(a.sums);
  r.in_front = local.in_front;
  const int num_found = a.sums.num_found[0] + a.sums.num_found[1];
  r.fitting = num_found > 0 ? static_cast<double>(a.sums.num_fitting[0] + a.sums.num_fitting[1]) / num_found : 0.0;
  r.num_pairs = a.sums.num_pairs;
  r.num_iterations = a.num_iterations;
  r.center = target.middle();
  if (a.sums.num_pairs < kMinTrustedPairs) return r;
  r.median_residual = target.scale() * a.median_residual;
  r.rms_residual = target.scale() * std::sqrt(a.sums.weighted_squares / a.sums.weight);
  r.covariance = covariance_of(a.sums, target, source);
  const ChangedSurface changed = look_for_change(target, source, a.target_from_source);
  r.staying = changed.staying;
  r.misjudged = changed.misjudged;
  const double distance = target.fine().distance();
  const double most_residual =
      std::max(kMaxResidual * distance, kMaxScatter * std::sqrt(a.sums.variance / a.sums.weight));
  if (r.overlap < options.min_overlap) {
    r.status = RegistrationStatus::TooFewPairs;
  } else if (r.in_front.value_or(0.0) > options.max_in_front || a.residual_scale > most_residual) {
    r.status = RegistrationStatus::PoorFit;
  } else if (const auto open = open_directions(a.sums); open.cols() > 0) {
    r.status = RegistrationStatus::Degenerate;
    r.unconstrained_dofs = in_frame(unconstrained_dofs(open), target);
  } else {
    r.status =
        a.last_step <= kConvergedStep * distance ? RegistrationStatus::Converged : RegistrationStatus::IterationLimit;
  }
  return r;
}

/// @param middles  Candidates after the middle stage, best first; one at least.
PairRegistration best_finalist(const PreparedScan& target, const PreparedScan& source,
                               const std::vector<PoseCandidate>& middles, const RegistrationOptions& options,
                               const RunControl& control) {
  struct Finalist {
    PairRegistration pair;
    double score = 0.0, residual_scale = 0.0;
  };
  std::vector<Finalist> finalists;
  for (const PoseCandidate& middle : middles) {
    if (middle.score < kFinalist * middles.front().score) break;
    const Local local = align_fully(target, source, middle.pose, options, control);
    finalists.push_back({judge(target, source, local, options),
                         pose_score(local.alignment, local.in_front.value_or(0.0), target.fine().distance()),
                         local.alignment.residual_scale});
  }
  const auto is_worse = [](const Finalist& a, const Finalist& b) {
    return std::pair(is_found(a.pair.status), a.score) < std::pair(is_found(b.pair.status), b.score);
  };
  const Finalist& best = *std::max_element(finalists.begin(), finalists.end(), is_worse);
  PairRegistration found = best.pair;
  found.is_found_by_search = true;
  double least = kRivalScale * best.residual_scale;
  for (const Finalist& other : finalists) {
    const double turn = angle_between_deg(other.pair.target_from_source.rotation, found.target_from_source.rotation);
    if (turn < kSamePoseDeg || !is_found(other.pair.status) || other.residual_scale > least ||
        other.pair.overlap < kRivalOverlap * found.overlap)
      continue;
    least = other.residual_scale;
    found.ambiguous_deg = turn;
  }
  return found;
}

double score_of(const PairRegistration& r) { return r.overlap * std::pow(1.0 - r.in_front.value_or(0.0), 2); }

}  // namespace

SurfelAlignment look_at_pose(const PreparedScan& target, const PreparedScan& source, const RigidTransform& pose,
                             const RunControl& control) {
  const double distance = target.fine().distance();
  const auto look = [&](double gate) {
    return align_surfels(target.fine(), source.fine(), pose,
                         {.first_gate = gate, .last_gate = gate, .stride = 1, .max_iterations = 1, .step = kFixedStep},
                         control);
  };
  SurfelAlignment found = look(3.0 * distance);
  found =
      look(std::clamp(kLastGateScales * found.residual_scale, kLastGate * distance, 2.0 * target.coarse().distance()));
  found.target_from_source = pose;
  found.num_iterations = 0;
  found.last_step = 0.0;
  return found;
}

Matrix6 information_of(const SurfelAlignment& a, const PreparedScan& target, const PreparedScan& source) {
  if (!(a.sums.weight > 0.0)) return Matrix6::Zero();
  Matrix6 information = a.sums.information * weight_of_information(a.sums, target, source);
  const auto open = open_directions(a.sums);
  for (Eigen::Index k = 0; k < open.cols(); ++k) {
    const Matrix6 keep = Matrix6::Identity() - open.col(k) * open.col(k).transpose();
    information = keep * information * keep;
  }
  return information;
}

PairRegistration judge_pose(const PreparedScan& target, const PreparedScan& source,
                            const RigidTransform& target_from_source, const RegistrationOptions& options,
                            const RunControl& control) {
  Local local;
  local.alignment = look_at_pose(target, source, normalized(target_from_source, target, source), control);
  local.in_front =
      share_in_front(target, source, local.alignment.target_from_source,
                     sight_tolerance(local.alignment.residual_scale, target.fine().distance()), kLookedInFrontOfPose);
  PairRegistration r = judge(target, source, local, options);
  r.target_from_source = target_from_source;
  return r;
}

PairRegistration register_pair(const PreparedScan& target, const PreparedScan& source,
                               const std::optional<RigidTransform>& start, const RegistrationOptions& options,
                               const RunControl& control) {
  check_ranges(options);
  if (options.method != RegistrationMethod::Symmetric)
    throw InvalidInput("register_pair: this is the symmetric method; PCL's are in reference_methods.h");
  std::optional<PairRegistration> best;
  if (start && options.start != RegistrationStart::Global) {
    const double coarse = target.coarse().distance();
    const SurfelAlignment rough = align_surfels(
        target.coarse(), source.coarse(), normalized(*start, target, source),
        {.first_gate = 1.0, .last_gate = 2.0 * coarse, .stride = 1, .max_iterations = kMidIterations, .step = 1e-3},
        control);
    best = judge(target, source, align_fully(target, source, rough.target_from_source, options, control), options);
    if (is_found(best->status) || options.start == RegistrationStart::Given) {
      control.report(1.0);
      return *best;
    }
  }
  // Candidates are told apart by the middle stage, the best of them get the full one.
  std::vector<PoseCandidate> middles;
  for (const PoseCandidate& candidate : search_poses(target, source, kNumCandidates, control.part(0.0, 0.8))) {
    const SurfelAlignment middle = align_middle(target, source, candidate.pose, true, control);
    const double front =
        share_in_front(target, source, middle.target_from_source, 3.0 * target.fine().distance(), kLookedInFrontOfPose)
            .value_or(0.0);
    middles.push_back({middle.target_from_source, pose_score(middle, front, target.fine().distance())});
  }
  std::stable_sort(middles.begin(), middles.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  if (!middles.empty()) {
    PairRegistration found = best_finalist(target, source, middles, options, control);
    if (!best || is_found(found.status) || (!is_found(best->status) && score_of(found) > score_of(*best))) best = found;
  }
  control.report(1.0);
  return best.value_or(PairRegistration{});
}

PairRegistration register_pair(const PointCloud& target, const PointCloud& source,
                               const std::optional<RigidTransform>& start, const RegistrationOptions& options,
                               const RunControl& control) {
  const std::array<PointCloud, 2> both{target, source};
  const std::vector<PreparedScan> scans = prepare_scans(both, options, control);
  return register_pair(scans[0], scans[1], start, options, control);
}

}  // namespace patinate::capture
