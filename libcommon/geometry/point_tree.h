/// \file
/// Points with FLANN's exact k-d tree over them. Internal: what includes it sees FLANN.
#pragma once

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

#include <utility>
#include <vector>

#include "libcommon/geometry/mesh.h"

namespace patinate {

/// Immutable after construction; searches are thread-safe and exact.
class PointTree {
 public:
  /// @param points  At least one. @param leaf_size  Points that a leaf holds, > 0; never changes what is found.
  PointTree(std::vector<Vec3> points, int leaf_size)
      : points_(std::move(points)),
        tree_(flann::Matrix<double>(points_.front().data(), points_.size(), 3),
              flann::KDTreeSingleIndexParams(leaf_size)) {
    tree_.buildIndex();
  }
  PointTree(const PointTree&) = delete;  // the tree points at the points
  PointTree& operator=(const PointTree&) = delete;

  [[nodiscard]] const std::vector<Vec3>& points() const { return points_; }

  /// Offers points to `found`, with their squared distances, while they may be nearer than its worstDist().
  void search(const Vec3& p, flann::ResultSet<double>& found) const { tree_.findNeighbors(found, p.data(), kExact); }

 private:
  static inline const flann::SearchParams kExact{flann::FLANN_CHECKS_UNLIMITED, 0.0F};

  std::vector<Vec3> points_;
  flann::KDTreeSingleIndex<flann::L2_Simple<double>> tree_;
};

}  // namespace patinate
