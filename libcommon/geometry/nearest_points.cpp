#include "libcommon/geometry/nearest_points.h"

#include <limits>
#include <nanoflann.hpp>
#include <utility>

#include "libcommon/core/error.h"

namespace patinate {

namespace {

struct Cloud {
  std::vector<Vec3> points;
  // The names that nanoflann asks for.
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3, std::uint32_t>;

/// Keeps the nearest point that counts.
struct Filter {
  const Cloud& cloud;
  const std::function<bool(const Vec3&)>& counts;
  double squared;
  int index = -1;
  [[nodiscard]] double worstDist() const { return squared; }
  [[nodiscard]] bool full() const { return true; }
  [[nodiscard]] std::size_t size() const { return index >= 0 ? 1 : 0; }
  bool addPoint(double squared_distance, std::uint32_t i) {
    if (squared_distance < squared && counts(cloud.points[i])) {
      squared = squared_distance;
      index = static_cast<int>(i);
    }
    return true;
  }
};

}  // namespace

struct NearestPoints::Impl {
  Cloud cloud;
  Tree tree;
  explicit Impl(std::vector<Vec3> points)
      : cloud{std::move(points)}, tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(12)) {}
};

NearestPoints::NearestPoints(std::vector<Vec3> points) {
  if (points.empty()) throw InvalidInput("nearest points: there is no point");
  impl_ = std::make_unique<Impl>(std::move(points));
}
NearestPoints::~NearestPoints() = default;
NearestPoints::NearestPoints(NearestPoints&&) noexcept = default;
NearestPoints& NearestPoints::operator=(NearestPoints&&) noexcept = default;

NearestPoints::Found NearestPoints::nearest(const Vec3& p) const {
  std::uint32_t index = 0;
  double squared = 0.0;
  impl_->tree.knnSearch(p.data(), 1, &index, &squared);
  return {static_cast<int>(index), std::sqrt(squared)};
}

NearestPoints::Found NearestPoints::nearest_of(const Vec3& p, double below,
                                               const std::function<bool(const Vec3&)>& counts) const {
  Filter filter{impl_->cloud, counts, below * below};
  impl_->tree.findNeighbors(filter, p.data(), nanoflann::SearchParams());
  return {filter.index, filter.index >= 0 ? std::sqrt(filter.squared) : 0.0};
}

const Vec3& NearestPoints::point(int index) const { return impl_->cloud.points[static_cast<std::size_t>(index)]; }

}  // namespace patinate
