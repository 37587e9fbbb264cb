#include "capture/registration/surfel_alignment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr std::int64_t kSurfelsAChunk = 512;
constexpr double kScaleOfQuarter =
    3.1386;                         ///< A quarter of a normal distribution lies within 1 / 3.1386 standard deviations.
constexpr double kNarrower = 0.75;  ///< How fast the scale is narrowed,
constexpr double kNarrowest = 2.0;  ///< to so many times what the points' own scatter makes.
constexpr double kMinCosine = 0.5;  ///< Normals of partners: 60 degrees.
constexpr int kMinPairsToSolve = 12;  ///< Twice the six unknowns of a motion.
constexpr double kSureShare = 0.999;  ///< Share of a margin: rounding.

double quantile_of(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  return value_at_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size())));
}

struct Pair {
  int target;
  int source;
  double residual;
  double closeness;  ///< 1 - (distance / gate)^2, at least 0.
  bool is_swapped;   ///< Looked for from the target.
};

}  // namespace

SurfelSet::SurfelSet(std::vector<Surfel> surfels, double distance, bool is_oriented)
    : surfels_(std::move(surfels)), distance_(distance), is_oriented_(is_oriented) {
  std::vector<Vec3> positions;
  std::vector<double> variances;
  for (const Surfel& s : surfels_) {
    positions.push_back(s.position);
    variances.push_back(s.variance);
  }
  median_variance_ = median(std::move(variances));
  if (!positions.empty()) points_ = std::make_shared<const NearestPoints>(std::move(positions));
}

SurfelSet::Found SurfelSet::nearest(const Vec3& p, double radius, int hint) const {
  if (surfels_.empty()) return {};
  const NearestPoints::Nearest found = points_->nearest_below(p, radius, hint);
  if (found.index < 0) return {};
  return {found.index, 0.5 * (std::sqrt(found.squared_second) - std::sqrt(found.squared_distance))};
}

void PairSums::add(const PairSums& other) {
  information += other.information;
  crossed += other.crossed;
  gradient += other.gradient;
  weight += other.weight;
  weighted_squares += other.weighted_squares;
  num_pairs += other.num_pairs;
  for (std::size_t k = 0; k < 2; ++k) {
    num_looked[k] += other.num_looked[k];
    num_found[k] += other.num_found[k];
    num_fitting[k] += other.num_fitting[k];
  }
  variance += other.variance;
}

namespace {

class Aligner {
 public:
  Aligner(const SurfelSet& target, const SurfelSet& source, const RigidTransform& start,
          const AlignmentSchedule& schedule, const RunControl& control)
      : target_(target), source_(source), schedule_(schedule), control_(control.silent()) {
    result_.target_from_source = start;
    result_.gate = schedule.first_gate;
    known_of_source_.resize(source.size());
    known_of_target_.resize(target.size());
    for (const SurfelSet* set : {&target, &source}) {
      for (const Surfel& surfel : set->surfels()) reach_ = std::max(reach_, surfel.position.norm());
    }
    is_oriented_ = target.is_oriented() && source.is_oriented();
    base_variance_ = 0.5 * (target.median_variance() + source.median_variance());
  }

  SurfelAlignment run() {
    for (result_.num_iterations = 0; result_.num_iterations < schedule_.max_iterations;) {
      control_.throw_if_stopped();
      find_pairs();
      set_scale();
      sum_up();
      if (result_.sums.num_pairs < kMinPairsToSolve) return result_;
      step();
      ++result_.num_iterations;
      if (narrow_scale()) continue;
      if (result_.gate <= schedule_.last_gate && result_.last_step <= schedule_.step) break;
      narrow();
    }
    return result_;
  }

 private:
  /// A surfel's nearest, and up to which way traveled it stays that without being looked for.
  struct Known {
    int index = -1;
    double until = -1.0;
  };

  /// Partners of every stride-th surfel of both sets, in order.
  void find_pairs() {
    const RigidTransform source_from_target = result_.target_from_source.inverse();
    pairs_.clear();
    num_looked_ = num_found_ = {0, 0};
    look(source_, target_, result_.target_from_source, known_of_source_, false);
    look(target_, source_, source_from_target, known_of_target_, true);
  }

  void look(const SurfelSet& from, const SurfelSet& to, const RigidTransform& to_from, std::vector<Known>& knowns,
            bool is_swapped) {
    const std::int64_t n = (from.size() + schedule_.stride - 1) / schedule_.stride;
    found_.assign(static_cast<std::size_t>(n), {-1, -1, 0.0, -1.0, is_swapped});
    parallel_for(n, kSurfelsAChunk, control_, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t k = begin; k < end; ++k) {
        const int i = static_cast<int>(k) * schedule_.stride;
        const Surfel& s = from[i];
        if (s.is_border) continue;
        Pair& pair = found_[k];
        pair.closeness = -0.5;
        const Vec3 p = to_from.apply(s.position);
        Known& known = knowns[i];
        if (!(traveled_ < known.until)) {
          const SurfelSet::Found found = to.nearest(p, result_.gate, known.index);
          if (found.index < 0) continue;
          known = {found.index, traveled_ + kSureShare * found.margin};
        }
        const int j = known.index;
        const Surfel& t = to[j];
        if ((t.position - p).squaredNorm() > result_.gate * result_.gate) continue;
        if (t.is_border) continue;
        Vec3 normal = to_from.rotation * s.normal;
        const double cosine = normal.dot(t.normal);
        if ((is_oriented_ ? cosine : std::abs(cosine)) < kMinCosine) continue;
        const Vec3 middle_normal = (cosine < 0.0 ? Vec3(t.normal - normal) : Vec3(t.normal + normal)).normalized();
        const Vec3 gap = p - t.position;
        pair = is_swapped ? Pair{i, j, -gap.dot(middle_normal), 0.0, true}
                          : Pair{j, i, gap.dot(middle_normal), 0.0, false};
        pair.closeness = std::max(0.0, 1.0 - gap.squaredNorm() / (result_.gate * result_.gate));
      }
    });
    for (const Pair& pair : found_) {
      if (pair.closeness >= -0.75) ++num_looked_[is_swapped ? 1 : 0];
      if (pair.target < 0) continue;
      ++num_found_[is_swapped ? 1 : 0];
      pairs_.push_back(pair);
    }
  }

  /// Robust standard deviation of the residuals; a gate away at most, as coarse starts have no scale yet.
  void set_scale() {
    residuals_.clear();
    for (const Pair& pair : pairs_) residuals_.push_back(std::abs(pair.residual));
    const double floor = 1e-6 * target_.distance();
    result_.median_residual = quantile_of(residuals_, 0.5);
    result_.residual_scale = std::max(floor, std::min(limit_, kScaleOfQuarter * quantile_of(residuals_, 0.25)));
  }

  void sum_up() {
    const RigidTransform& t = result_.target_from_source;
    const double most = kTukeyLimit * result_.residual_scale;
    PairSums sums = parallel_reduce(
        static_cast<std::int64_t>(pairs_.size()), kSurfelsAChunk, control_, PairSums{},
        [&](std::int64_t begin, std::int64_t end) {
          PairSums part;
          for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
            const Pair& pair = pairs_[k];
            const double outlying = pair.residual / most;
            if (!(std::abs(outlying) < 1.0)) continue;
            ++part.num_fitting[pair.is_swapped ? 1 : 0];
            const Surfel& a = target_[pair.target];
            const Surfel& b = source_[pair.source];
            Vec3 nb = t.rotation * b.normal;
            double cosine = nb.dot(a.normal);
            if (cosine < 0.0) nb = -nb;
            cosine = std::abs(cosine);
            const double robust = 1.0 - outlying * outlying;
            const double likely = 2.0 * base_variance_ / (2.0 * base_variance_ + a.variance + b.variance);
            const double w =
                robust * robust * pair.closeness * std::max(0.0, (cosine - kMinCosine) / (1.0 - kMinCosine)) * likely;
            if (!(w > 0.0)) continue;
            const Vec3 middle = 0.5 * (a.position + t.apply(b.position));
            const Vec3 n = (a.normal + nb).normalized();
            Vec6 j, ja, jb;
            j << middle.cross(n), n;
            ja << middle.cross(a.normal), a.normal;
            jb << middle.cross(nb), nb;
            part.information.noalias() += w * j * j.transpose();
            part.crossed.noalias() += w * ja * jb.transpose();
            part.gradient += w * pair.residual * j;
            part.weight += w;
            part.weighted_squares += w * pair.residual * pair.residual;
            part.variance += w * (a.variance / a.num_points + b.variance / b.num_points);
            ++part.num_pairs;
          }
          return part;
        },
        [](PairSums sum, const PairSums& part) {
          sum.add(part);
          return sum;
        });
    sums.num_looked = num_looked_;
    sums.num_found = num_found_;
    sums.crossed = (0.5 * (sums.crossed + sums.crossed.transpose())).eval();
    result_.sums = sums;
  }

  void step() {
    const SymmetricEigen<Matrix6> solver = symmetric_eigen(result_.sums.information);
    const double least = kFreeShare * solver.values[5];
    Vec6 move = Vec6::Zero();
    result_.num_held = 0;
    for (int k = 0; k < 6; ++k) {
      const double value = solver.values[k];
      if (!(value > least)) {
        ++result_.num_held;
        continue;
      }
      const Vec6 direction = solver.vectors.col(k);
      move -= direction * (direction.dot(result_.sums.gradient) / value);
    }
    RigidTransform moved{rotation_of(move.head<3>()), move.tail<3>()};
    result_.target_from_source = moved * result_.target_from_source;
    result_.last_step = std::max(move.head<3>().norm(), move.tail<3>().norm());
    // Source positions turn about the target's origin, from wherever they are there.
    traveled_ +=
        move.head<3>().norm() * (reach_ + result_.target_from_source.translation.norm() + move.tail<3>().norm()) +
        move.tail<3>().norm();
  }

  /// Where a part of the surface has changed, a scale that takes it for noise can hold itself up. So, once all has
  /// settled, the scale is forced down to the points' own scatter, and then let go: it stays down if the rest fits
  /// without the changed part.
  /// @returns whether it was forced down.
  bool narrow_scale() {
    if (!schedule_.narrows_scale || is_narrowed_ || result_.gate > schedule_.last_gate) return false;
    if (limit_ == kNoLimit) {
      if (result_.last_step > kSettled * schedule_.step) return false;
      limit_ = result_.residual_scale;
    }
    limit_ *= kNarrower;
    if (limit_ > kNarrowest * std::sqrt(result_.sums.variance / result_.sums.weight)) return true;
    limit_ = kNoLimit;
    is_narrowed_ = true;
    return true;
  }

  /// The gate follows what the partners are apart, and falls all the way.
  void narrow() {
    residuals_.clear();
    for (const Pair& pair : pairs_) residuals_.push_back(1.0 - pair.closeness);
    const double median_distance = result_.gate * std::sqrt(std::max(0.0, quantile_of(residuals_, 0.5)));
    result_.gate = std::max(schedule_.last_gate, std::min(0.8 * result_.gate, 2.5 * median_distance));
  }

  const SurfelSet& target_;
  const SurfelSet& source_;
  AlignmentSchedule schedule_;
  RunControl control_;
  bool is_oriented_ = false;
  double base_variance_ = 0.0;
  SurfelAlignment result_;
  std::vector<Known> known_of_source_, known_of_target_;
  double traveled_ = 0.0;  ///< Bound of every surfel's motion, in all steps so far.
  double reach_ = 0.0;     ///< Farthest position from the origin, of both sets.
  std::vector<Pair> found_, pairs_;
  std::array<int, 2> num_looked_{}, num_found_{};
  std::vector<double> residuals_;
  static constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  static constexpr double kSettled = 10.0;  ///< In steps of the schedule.
  double limit_ = kNoLimit;
  bool is_narrowed_ = false;
};

}  // namespace

SurfelAlignment align_surfels(const SurfelSet& target, const SurfelSet& source, const RigidTransform& start,
                              const AlignmentSchedule& schedule, const RunControl& control) {
  return Aligner(target, source, start, schedule, control).run();
}

}  // namespace patinate::capture
