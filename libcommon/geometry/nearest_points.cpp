#include "libcommon/geometry/nearest_points.h"

#include <cmath>
#include <limits>
#include <utility>

#include "libcommon/core/error.h"
#include "libcommon/geometry/point_tree.h"

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

}  // namespace

struct NearestPoints::Impl {
  PointTree tree;
  explicit Impl(std::vector<Vec3> points) : tree(std::move(points), 12) {}
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
  impl_->tree.search(p, found);
  return found.found();
}

NearestPoints::Found NearestPoints::nearest_of(const Vec3& p, double below,
                                               const std::function<bool(const Vec3&)>& counts) const {
  const auto counts_at = [&](std::size_t i) { return counts(impl_->tree.points()[i]); };
  NearestThatCounts found(below * below, counts_at);
  impl_->tree.search(p, found);
  return found.found();
}

const Vec3& NearestPoints::point(int index) const { return impl_->tree.points()[static_cast<std::size_t>(index)]; }

}  // namespace patinate
