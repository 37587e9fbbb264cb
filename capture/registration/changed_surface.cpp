#include "capture/registration/changed_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

constexpr double kPartnerGate = 3.0;    ///< In fine distances, as look_at_pose() begins.
constexpr double kPartnerCosine = 0.5;  ///< Normals of partners: 60 degrees, as when scans are aligned.
constexpr double kStaysWithin = 3.0;    ///< Deviations of the points' scatter,
constexpr double kSpreadRank = 0.95,
                 kSpreadOfNormal = 1.96;  ///< Rank of |distance|, and its value in deviations of a normal distribution.
constexpr int kPartRounds = 2;            ///< Few: a part that lies at one end would run off sideways.
constexpr double kSmallestPart = 0.1;     ///< Share of the surface: less than a tenth carries no pose.
constexpr std::size_t kMinPartners = 30;  ///< Fewer partners do not show a distribution of distances.
constexpr std::int64_t kPartnersAChunk = 512;

/// A surfel of the source and its partner.
struct Partners {
  Vec6 row = Vec6::Zero();  ///< Derivative of the source's height there by a small motion.
  double raised = 0.0;      ///< How much higher the source lies, along the normal.
  double variance = -1.0;   ///< Variance if the noise were that of the points; < 0: no partner.
};

/// Where normals point to either side: the axis that most of them lie along. A scan shows a surface from one side, so
/// that its normals toward one end of the axis are those outward or those inward; which does not matter here.
Vec3 main_axis(const SurfelSet& set) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Surfel& s : set.surfels()) sum += s.normal * s.normal.transpose();
  return symmetric_eigen(sum).vectors.col(2);
}

std::vector<Partners> partners_in(const SurfelSet& target, const SurfelSet& source, const RigidTransform& pose,
                                  const RunControl& control) {
  std::vector<Partners> all(static_cast<std::size_t>(source.size()));
  const bool is_oriented = target.is_oriented() && source.is_oriented();
  const Vec3 axis = main_axis(target);
  parallel_for(source.size(), kPartnersAChunk, control.silent(), [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      const Surfel& s = source[static_cast<int>(k)];
      if (s.is_border) continue;
      const Vec3 p = pose.apply(s.position);
      const int j = target.nearest(p, kPartnerGate * target.distance(), -1).index;
      if (j < 0 || target[j].is_border) continue;
      const Surfel& t = target[j];
      Vec3 normal = pose.rotation * s.normal, normal_there = t.normal;
      if (!is_oriented && normal_there.dot(axis) < 0.0) normal_there = -normal_there;
      if (!is_oriented && normal.dot(normal_there) < 0.0) normal = -normal;
      if (normal.dot(normal_there) < kPartnerCosine) continue;
      const Vec3 n = (normal_there + normal).normalized(), middle = 0.5 * (t.position + p);
      Partners& found = all[k];
      found.row << middle.cross(n), n;
      found.raised = (p - t.position).dot(n);
      found.variance = s.variance / s.num_points + t.variance / t.num_points;
    }
  });
  std::erase_if(all, [](const Partners& p) { return p.variance < 0.0; });
  return all;
}

/// A part of the partners, and the motion after which it lies evenly about the target.
struct PartMove {
  Vec6 move = Vec6::Zero();
  double spread = 0.0;  ///< Root mean square of what is left of its distances.
};

/// Motion of the part that lies lowest. @param side  -1: highest.
PartMove part_move(const std::vector<Partners>& partners, double share, double side) {
  PartMove part;
  const std::size_t n =
      std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(partners.size())));
  std::vector<std::pair<double, std::size_t>> order(partners.size());
  for (int round = 0; round < kPartRounds; ++round) {
    for (std::size_t i = 0; i < partners.size(); ++i)
      order[i] = {side * (partners[i].raised + partners[i].row.dot(part.move)), i};
    std::sort(order.begin(), order.end());
    Matrix6 information = Matrix6::Zero();
    Vec6 gradient = Vec6::Zero();
    for (std::size_t k = 0; k < n; ++k) {
      const Partners& p = partners[order[k].second];
      information += p.row * p.row.transpose();
      gradient += side * order[k].first * p.row;
    }
    const SymmetricEigen<Matrix6> solver = symmetric_eigen(information);
    for (int d = 0; d < 6; ++d) {
      const Vec6 direction = solver.vectors.col(d);
      if (solver.values[d] > kFreeShare * solver.values[5])
        part.move -= direction * (direction.dot(gradient) / solver.values[d]);
    }
  }
  double squares = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const Partners& p = partners[order[k].second];
    const double rest = p.raised + p.row.dot(part.move);
    squares += rest * rest;
  }
  part.spread = std::sqrt(squares / static_cast<double>(n));
  return part;
}

}  // namespace

bool is_misled_by_change(double staying, const Vec6& misjudged, double spacing) {
  return staying < ChangedSurface::kMinStaying && misjudged.tail<3>().norm() > ChangedSurface::kMaxMisjudged * spacing;
}

ChangedSurface look_for_change(const PreparedScan& target, const PreparedScan& source, const RigidTransform& pose,
                               const RunControl& control) {
  ChangedSurface found;
  const std::vector<Partners> partners = partners_in(target.fine(), source.fine(), pose, control);
  if (partners.size() < kMinPartners) return found;
  const auto num_staying = std::count_if(partners.begin(), partners.end(), [](const Partners& p) {
    return p.raised * p.raised <= kStaysWithin * kStaysWithin * p.variance;
  });
  found.staying = static_cast<double>(num_staying) / static_cast<double>(partners.size());
  std::vector<double> spread;
  for (const Partners& p : partners) spread.push_back(p.raised * p.raised / p.variance);
  const auto rank = static_cast<std::size_t>(kSpreadRank * static_cast<double>(spread.size() - 1));
  const double more_than_noise =
      std::max(0.0, 1.0 - kSpreadOfNormal * kSpreadOfNormal / std::max(value_at_rank(spread, rank), 1e-12));
  const double share = std::clamp(found.staying, kSmallestPart, 0.5);
  const PartMove lowest = part_move(partners, share, 1.0), highest = part_move(partners, share, -1.0);
  Vec6 move = std::sqrt(more_than_noise) * (lowest.spread < highest.spread ? lowest : highest).move;
  move.tail<3>() *= target.scale();
  found.misjudged = move;
  return found;
}

}  // namespace patinate::capture
