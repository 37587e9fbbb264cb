#include "libcommon/geometry/nearest_points.h"

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

#include <cmath>
#include <limits>
#include <utility>

#include "patinate/core/error.h"

namespace patinate {

namespace {

/// Keeps the nearest point that counts.
template <class Counts>
class NearestThatCounts final : public flann::ResultSet<double> {
 public:
  NearestThatCounts(double below_squared, const Counts& counts) : squared_(below_squared), counts_(counts) {}
  [[nodiscard]] bool full() const override { return true; }
  [[nodiscard]] double worstDist() const override { return squared_; }
  void addPoint(double squared, std::size_t i) override {
    if (!(squared < squared_) || !counts_(i)) return;
    squared_ = squared;
    index_ = static_cast<int>(i);
  }
  [[nodiscard]] NearestPoints::Found found() const { return {index_, index_ >= 0 ? std::sqrt(squared_) : 0.0}; }

 private:
  double squared_;
  const Counts& counts_;
  int index_ = -1;
};

/// Keeps the nearest point below a distance, of several at the same the one with the smallest index, and how far the
/// next one is.
class NearestAndNext final : public flann::ResultSet<double> {
 public:
  explicit NearestAndNext(const NearestPoints::Nearest& known) : found_(known) {}
  [[nodiscard]] bool full() const override { return true; }
  [[nodiscard]] double worstDist() const override { return found_.squared_second; }
  void addPoint(double squared, std::size_t i) override {
    const int at = static_cast<int>(i);
    if (at == found_.index) return;
    if (squared < found_.squared_distance ||
        (squared == found_.squared_distance && (found_.index < 0 || at < found_.index))) {
      if (found_.index >= 0) found_.squared_second = found_.squared_distance;
      found_.squared_distance = squared;
      found_.index = at;
    } else if (squared < found_.squared_second) {
      found_.squared_second = squared;
    }
  }
  [[nodiscard]] const NearestPoints::Nearest& found() const { return found_; }

 private:
  NearestPoints::Nearest found_;
};

constexpr int kPointsPerLeaf = 8;
const flann::SearchParams kExact{flann::FLANN_CHECKS_UNLIMITED, 0.0F};

}  // namespace

struct NearestPoints::Impl {
  std::vector<Vec3> points;
  flann::KDTreeSingleIndex<flann::L2_Simple<double>> tree;
  explicit Impl(std::vector<Vec3> given)
      : points(std::move(given)),
        tree(flann::Matrix<double>(points.front().data(), points.size(), 3),
             flann::KDTreeSingleIndexParams(kPointsPerLeaf)) {
    tree.buildIndex();
  }
};

NearestPoints::NearestPoints(std::vector<Vec3> points) {
  if (points.empty()) throw InvalidInput("nearest points: there is no point");
  impl_ = std::make_unique<Impl>(std::move(points));
}
NearestPoints::~NearestPoints() = default;
NearestPoints::NearestPoints(NearestPoints&&) noexcept = default;
NearestPoints& NearestPoints::operator=(NearestPoints&&) noexcept = default;

NearestPoints::Found NearestPoints::nearest(const Vec3& p) const {
  const auto all = [](std::size_t) { return true; };
  NearestThatCounts found(std::numeric_limits<double>::infinity(), all);
  impl_->tree.findNeighbors(found, p.data(), kExact);
  return found.found();
}

NearestPoints::Found NearestPoints::nearest_of(const Vec3& p, double below,
                                               const std::function<bool(const Vec3&)>& counts) const {
  const auto counts_at = [&](std::size_t i) { return counts(impl_->points[i]); };
  NearestThatCounts found(below * below, counts_at);
  impl_->tree.findNeighbors(found, p.data(), kExact);
  return found.found();
}

NearestPoints::Nearest NearestPoints::nearest_below(const Vec3& p, double below, int hint) const {
  Nearest known{.squared_distance = below * below, .squared_second = below * below};
  if (hint >= 0) {
    const double squared = (point(hint) - p).squaredNorm();
    if (squared <= known.squared_distance)
      known = {.index = hint, .squared_distance = squared, .squared_second = known.squared_second};
  }
  NearestAndNext found(known);
  impl_->tree.findNeighbors(found, p.data(), kExact);
  return found.found();
}

const Vec3& NearestPoints::point(int index) const { return impl_->points[index]; }

}  // namespace patinate
