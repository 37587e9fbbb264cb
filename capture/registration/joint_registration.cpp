#include "capture/registration/joint_registration.h"

#include <algorithm>
#include <cmath>

#include "capture/registration/changed_surface.h"
#include "capture/registration/pose_graph.h"
#include "capture/registration/prepared_scan.h"
#include "capture/registration/reference_methods.h"
#include "capture/registration/unconstrained_dof.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kNearInCoarse = 1.5;   ///< Coarse surfels this near, in their distance, and facing alike may overlap.
constexpr double kMostOfIt = 0.5;       ///< Overlap with the reference from which most of a scan can have changed.
constexpr int kMaxRounds = 12;          ///< Rounds of partners and poses; it ends earlier where poses rest.
constexpr double kSettled = 1e-7;       ///< Normalized: nothing moves any more.
constexpr double kContradiction = 3.0;  ///< Fine distances by which an edge that is excluded is off.

/// Share of the smaller scan's coarse surfels that lie near the other's and face alike.
double coarse_overlap(const PreparedScan& target, const PreparedScan& source, const RigidTransform& pose) {
  const bool is_target_smaller = target.coarse().size() < source.coarse().size();
  const SurfelSet& from = is_target_smaller ? target.coarse() : source.coarse();
  const SurfelSet& to = is_target_smaller ? source.coarse() : target.coarse();
  const RigidTransform to_from = is_target_smaller ? pose.inverse() : pose;
  int num_near = 0;
  for (const Surfel& s : from.surfels()) {
    const int j = to.nearest(to_from.apply(s.position), kNearInCoarse * to.distance(), -1).index;
    if (j >= 0 && std::abs((to_from.rotation * s.normal).dot(to[j].normal)) > 0.5) ++num_near;
  }
  return from.size() == 0 ? 0.0 : static_cast<double>(num_near) / from.size();
}

class JointSolver {
 public:
  JointSolver(std::span<const PointCloud> scans, std::span<const std::optional<RigidTransform>> initial, int reference,
              const RegistrationOptions& options, const RunControl& control)
      : clouds_(scans),
        initial_(initial),
        reference_(reference),
        options_(options),
        control_(control),
        scans_(prepare_scans(scans, options, control)) {
    result_.scans.resize(scans.size());
    poses_.resize(scans.size());
    has_pose_.assign(scans.size(), false);
  }

  JointRegistration run() {
    begin_poses();
    add_edges();
    choose_tree();
    measure_closure();
    solve();
    report();
    control_.report(1.0);
    return std::move(result_);
  }

 private:
  [[nodiscard]] const PreparedScan& scan(int k) const { return scans_[k]; }
  [[nodiscard]] RigidTransform& pose(int k) { return poses_[k]; }
  [[nodiscard]] int num_scans() const { return static_cast<int>(scans_.size()); }
  /// target from source in the scans' unit, in the poses as they are.
  [[nodiscard]] RigidTransform relative(int target, int source) {
    return in_unit(pose(target).inverse() * pose(source), scan(target), scan(source));
  }

  PairRegistration register_edge(int target, int source, const std::optional<RigidTransform>& start, bool may_search) {
    control_.throw_if_stopped();
    RegistrationOptions options = options_;
    if (!may_search) options.start = RegistrationStart::Given;
    const RunControl quiet = control_.silent();
    if (options.method == RegistrationMethod::Symmetric)
      return register_pair(scan(target), scan(source), start, options, quiet);
    return register_pair_with_pcl(clouds_[target], clouds_[source], start.value_or(RigidTransform{}), options, quiet);
  }

  std::optional<RigidTransform> initial_relative(int target, int source) const {
    if (initial_.empty()) return RigidTransform{};
    const auto& a = initial_[target];
    const auto& b = initial_[source];
    return a && b ? std::optional(a->inverse() * *b) : std::nullopt;
  }

  /// Every scan by the first that it fits of those with poses; the scan with the best fit first, where the start is
  /// near enough for that.
  void begin_poses() {
    const auto r = static_cast<std::size_t>(reference_);
    has_pose_[r] = true;
    result_.scans[r].status = RegistrationStatus::Converged;
    std::vector<std::pair<int, int>> tried;
    for (bool may_search : {false, true}) {
      if (may_search && options_.start == RegistrationStart::Given) break;
      for (bool has_grown = true; has_grown;) {
        has_grown = false;
        for (int source = 0; source < num_scans(); ++source) {
          if (has_pose_[source]) continue;
          for (int step = 0; step < num_scans() && !has_pose_[source]; ++step) {
            // The reference first, then the neighbors in time.
            const int target = step == 0 ? reference_ : partner_in_order(source, step);
            if (target < 0 || target == source || !has_pose_[target]) continue;
            const std::pair<int, int> attempt{target, may_search ? source + num_scans() : source};
            if (std::find(tried.begin(), tried.end(), attempt) != tried.end()) continue;
            tried.push_back(attempt);
            has_grown = begin_pose(target, source, may_search) || has_grown;
          }
        }
        control_.report(0.5 * static_cast<double>(std::count(has_pose_.begin(), has_pose_.end(), true)) / num_scans());
      }
    }
  }

  /// step 1, 2, 3, ...: source - 1, source + 1, source - 2, ...; -1 = beyond the ends.
  [[nodiscard]] int partner_in_order(int source, int step) const {
    const int target = source + (step % 2 == 1 ? -(step + 1) / 2 : step / 2);
    return target >= 0 && target < num_scans() ? target : -1;
  }

  bool begin_pose(int target, int source, bool may_search) {
    const std::optional<RigidTransform> start = may_search ? std::nullopt : initial_relative(target, source);
    if (!may_search && (!start || options_.start == RegistrationStart::Global)) return false;
    if (!may_search && coarse_overlap(scan(target), scan(source), normalized(*start, scan(target), scan(source))) <
                           0.5 * options_.min_overlap)
      return false;
    const PairRegistration found = register_edge(target, source, start, may_search);
    RegisteredScan& s = result_.scans[source];
    if (!is_found(found.status)) {
      if (s.partner < 0 || found.overlap > s.overlap) {
        s.status = found.status;
        s.partner = target;
        s.overlap = found.overlap;
        s.rms_residual = found.rms_residual;
      }
      return false;
    }
    has_pose_[source] = true;
    s.is_found_by_search = found.is_found_by_search;
    s.ambiguous_deg = found.ambiguous_deg;
    pose(source) = pose(target) * normalized(found.target_from_source, scan(target), scan(source));
    result_.edges.push_back({.target = target, .source = source, .pair = found, .is_in_tree = true});
    return true;
  }

  void add_edges() {
    for (int a = 0; a < num_scans(); ++a) {
      for (int b = a + 1; b < num_scans(); ++b) {
        if (!has_pose_[a] || !has_pose_[b]) continue;
        const bool is_there = std::any_of(result_.edges.begin(), result_.edges.end(), [&](const RegistrationEdge& e) {
          return std::minmax(e.target, e.source) == std::minmax(a, b);
        });
        if (is_there || coarse_overlap(scan(a), scan(b), pose(a).inverse() * pose(b)) < options_.min_overlap) continue;
        const PairRegistration found = register_edge(a, b, relative(a, b), false);
        if (is_found(found.status)) result_.edges.push_back({.target = a, .source = b, .pair = found});
      }
      control_.report(0.5 + 0.3 * (a + 1) / num_scans());
    }
    std::stable_sort(result_.edges.begin(), result_.edges.end(),
                     [](const RegistrationEdge& x, const RegistrationEdge& y) {
                       return std::pair(x.target, x.source) < std::pair(y.target, y.source);
                     });
  }

  /// The chain that the poses begin with: the edges that overlap most and join all scans [Kruskal 1956].
  void choose_tree() {
    std::vector<RegistrationEdge*> by_overlap;
    for (RegistrationEdge& e : result_.edges) by_overlap.push_back(&e);
    std::stable_sort(by_overlap.begin(), by_overlap.end(), [](const RegistrationEdge* a, const RegistrationEdge* b) {
      return a->pair.overlap > b->pair.overlap;
    });
    std::vector<int> group(scans_.size());
    for (std::size_t k = 0; k < group.size(); ++k) group[k] = static_cast<int>(k);
    for (RegistrationEdge* e : by_overlap) {
      const int from = group[e->source], to = group[e->target];
      e->is_in_tree = from != to;
      if (e->is_in_tree) std::replace(group.begin(), group.end(), from, to);
    }
    std::vector<bool> is_placed(scans_.size(), false);
    is_placed[reference_] = true;
    for (bool has_grown = true; has_grown;) {
      has_grown = false;
      for (const RegistrationEdge& e : result_.edges) {
        const bool has_target = is_placed[e.target], has_source = is_placed[e.source];
        if (!e.is_in_tree || has_target == has_source) continue;
        const RigidTransform t = normalized(e.pair.target_from_source, scan(e.target), scan(e.source));
        (has_target ? pose(e.source) : pose(e.target)) = has_target ? pose(e.target) * t : pose(e.source) * t.inverse();
        is_placed[has_target ? e.source : e.target] = has_grown = true;
      }
    }
  }

  void measure_closure() {
    std::vector<double> angles, shifts;
    for (RegistrationEdge& e : result_.edges) {
      if (e.is_in_tree) continue;
      const RigidTransform around = relative(e.target, e.source);
      e.closure_deg = angle_between_deg(around.rotation, e.pair.target_from_source.rotation);
      e.closure =
          (around.apply(scan(e.source).middle()) - e.pair.target_from_source.apply(scan(e.source).middle())).norm();
      angles.push_back(e.closure_deg);
      shifts.push_back(e.closure);
    }
    if (angles.empty()) return;
    std::sort(angles.begin(), angles.end());
    std::sort(shifts.begin(), shifts.end());
    result_.largest_closure_deg = angles.back();
    result_.largest_closure = shifts.back();
    result_.median_closure_deg = angles[angles.size() / 2];
    result_.median_closure = shifts[shifts.size() / 2];
  }

  /// The edges as they measure themselves (first), or as their normal equations in the joint poses continue.
  std::vector<PoseEdge> measured(bool is_first) {
    std::vector<PoseEdge> edges;
    for (RegistrationEdge& e : result_.edges) {
      if (!e.is_used) continue;
      const RigidTransform at = is_first ? normalized(e.pair.target_from_source, scan(e.target), scan(e.source))
                                         : pose(e.target).inverse() * pose(e.source);
      const RunControl quiet = control_.silent();
      const SurfelAlignment a = look_at_pose(scan(e.target), scan(e.source), at, quiet);
      PoseEdge edge{e.target, e.source, at, information_of(a, scan(e.target), scan(e.source))};
      if (!is_first) {
        const SymmetricEigen<Matrix6> solver = symmetric_eigen(a.sums.information);
        Vec6 move = Vec6::Zero();
        for (int k = 0; k < 6; ++k) {
          const double value = solver.values[k];
          const Vec6 direction = solver.vectors.col(k);
          if (value > kFreeShare * solver.values[5]) move -= direction * (direction.dot(a.sums.gradient) / value);
        }
        edge.target_from_source = RigidTransform{rotation_of(move.head<3>()), move.tail<3>()} * at;
      }
      edges.push_back(edge);
    }
    return edges;
  }

  void solve() {
    for (;;) {
      edges_ = measured(true);
      if (edges_.empty()) return;
      poses_ = solve_poses(poses_, edges_, reference_);
      if (!leave_out_worst()) break;
    }
    if (options_.method != RegistrationMethod::Symmetric) return;
    for (result_.num_rounds = 0; result_.num_rounds < kMaxRounds;) {
      control_.throw_if_stopped();
      edges_ = measured(false);
      const std::vector<RigidTransform> before = poses_;
      poses_ = solve_poses(poses_, edges_, reference_);
      ++result_.num_rounds;
      double moved = 0.0;
      for (std::size_t k = 0; k < poses_.size(); ++k) {
        moved = std::max({moved, (poses_[k].translation - before[k].translation).norm(),
                          (poses_[k].rotation - before[k].rotation).norm()});
      }
      control_.report(0.8 + 0.2 * result_.num_rounds / (kMaxRounds + 1));
      if (moved < kSettled) break;
    }
  }

  /// An edge outside the tree that is far off what all say together was a wrong pair.
  bool leave_out_worst() {
    RegistrationEdge* worst = nullptr;
    double most = kContradiction * scan(reference_).fine().distance();
    for (RegistrationEdge& e : result_.edges) {
      if (!e.is_used || e.is_in_tree || e.pair.status == RegistrationStatus::Degenerate) continue;
      const RigidTransform off = (pose(e.target).inverse() * pose(e.source)) *
                                 normalized(e.pair.target_from_source, scan(e.target), scan(e.source)).inverse();
      const double by = off.translation.norm() + axis_angle_of(off.rotation).norm();
      if (by > most) {
        most = by;
        worst = &e;
      }
    }
    if (worst != nullptr) worst->is_used = false;
    return worst != nullptr;
  }

  void report() {
    const std::vector<Matrix6> covariances = pose_covariances(poses_, edges_, reference_);
    const double scale = scan(reference_).scale();
    Vec6 unit;
    unit << 1, 1, 1, scale, scale, scale;
    std::vector<double> squares(scans_.size(), 0.0);
    std::vector<int> counts(scans_.size(), 0);
    for (RegistrationEdge& e : result_.edges) {
      const PairRegistration joint =
          judge_pose(scan(e.target), scan(e.source), relative(e.target, e.source), options_, {});
      e.median_residual = joint.median_residual;
      for (const int k : {e.target, e.source}) {
        RegisteredScan& s = result_.scans[k];
        squares[k] += joint.num_pairs * joint.rms_residual * joint.rms_residual;
        counts[k] += joint.num_pairs;
        if (s.partner >= 0 && has_pose_[k] && joint.overlap <= s.overlap) continue;
        s.partner = k == e.target ? e.source : e.target;
        s.overlap = joint.overlap;
      }
    }
    for (int k = 0; k < num_scans(); ++k) {
      RegisteredScan& s = result_.scans[k];
      const auto i = static_cast<std::size_t>(k);
      if (!has_pose_[i]) {
        if (const auto start = initial_relative(reference_, k)) s.reference_from_scan = *start;
        s.center = s.reference_from_scan.apply(scan(k).middle());
        continue;
      }
      s.reference_from_scan = in_unit(pose(k), scan(reference_), scan(k));
      s.center = s.reference_from_scan.apply(scan(k).middle());
      if (counts[i] > 0) s.rms_residual = std::sqrt(squares[i] / counts[i]);
      s.status = RegistrationStatus::Converged;
      if (k == reference_) continue;
      const RigidTransform about{Eigen::Matrix3d::Identity(), -(s.center - scan(reference_).middle()) / scale};
      const Matrix6 to_center = adjoint(about);
      s.covariance = unit.asDiagonal() * (to_center * covariances[i] * to_center.transpose()) * unit.asDiagonal();
      look_for_change_since_reference(k, s);
      name_unconstrained_dofs(k, s);
    }
  }

  /// Looks at the reference itself, whether the two were found to fit as a pair or not: where the surface grows from
  /// scan to scan, neighbors in time fit and hold the chain together, and those far apart no longer do.
  void look_for_change_since_reference(int k, RegisteredScan& s) {
    const RigidTransform at = pose(reference_).inverse() * pose(k);
    if (coarse_overlap(scan(reference_), scan(k), at) < options_.min_overlap) return;
    const ChangedSurface changed = look_for_change(scan(reference_), scan(k), at, control_.silent());
    s.staying = changed.staying;
    Vec6 moved = changed.misjudged;  // About the reference's middle.
    moved.tail<3>() += Vec3(moved.head<3>()).cross(s.center - scan(reference_).middle());
    s.covariance += moved * moved.transpose();
    s.is_misled = is_misled_by_change(s.staying, changed.misjudged,
                                      scan(reference_).scale() * scan(reference_).fine().distance());
    if (s.is_misled && overlap_of(look_at_pose(scan(reference_), scan(k), at, control_.silent()).sums) < kMostOfIt)
      s.is_misled = false;
    if (s.is_misled) s.status = RegistrationStatus::PoorFit;
  }

  /// A scan whose edges together leave a direction open.
  void name_unconstrained_dofs(int k, RegisteredScan& s) {
    Matrix6 information = Matrix6::Zero();
    for (const PoseEdge& e : edges_) {
      if (e.target != k && e.source != k) continue;
      const Matrix6 to_target = adjoint(pose(e.target).inverse());
      information += to_target.transpose() * e.information * to_target;
    }
    const SymmetricEigen<Matrix6> solver = symmetric_eigen(information);
    Eigen::Matrix<double, 6, Eigen::Dynamic> open(6, 0);
    for (int d = 0; d < 6; ++d) {
      if (solver.values[d] > kFreeShare * solver.values[5]) continue;
      open.conservativeResize(6, open.cols() + 1);
      open.col(open.cols() - 1) = solver.vectors.col(d);
    }
    if (open.cols() == 0) return;
    s.status = RegistrationStatus::Degenerate;
    s.unconstrained_dofs = in_frame(unconstrained_dofs(open), scan(reference_));
  }

  std::span<const PointCloud> clouds_;
  std::span<const std::optional<RigidTransform>> initial_;
  int reference_;
  RegistrationOptions options_;
  RunControl control_;
  std::vector<PreparedScan> scans_;
  std::vector<RigidTransform> poses_;  ///< Normalized: reference from scan.
  std::vector<bool> has_pose_;
  std::vector<PoseEdge> edges_;
  JointRegistration result_;
};

}  // namespace

JointRegistration register_jointly(std::span<const PointCloud> scans,
                                   std::span<const std::optional<RigidTransform>> initial, int reference,
                                   const RegistrationOptions& options, const RunControl& control) {
  if (scans.size() < 2)
    throw InvalidInput("registration: found " + std::to_string(scans.size()) + " scans; at least 2 are needed");
  if (!initial.empty() && initial.size() != scans.size())
    throw InvalidInput("registration: as many initial poses as scans are needed, or none");
  if (reference < 0 || reference >= static_cast<int>(scans.size()))
    throw InvalidInput("registration: there is no scan " + std::to_string(reference));
  return JointSolver(scans, initial, reference, options, control).run();
}

}  // namespace patinate::capture
