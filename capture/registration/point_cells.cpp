#include "capture/registration/point_cells.h"

#include <algorithm>
#include <utility>

namespace patinate::capture {

PointCells::PointCells(std::span<const Vec3> points, double cell) : cell_(cell), per_cell_(1.0 / cell) {
  std::uint64_t size = 64;
  while (size < 2 * points.size()) size *= 2;
  mask_ = size - 1;
  table_.assign(size, -1);
  std::vector<int> cell_of(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Key key = key_of(points[i]);
    std::uint64_t at = hash(key) & mask_;
    while (table_[at] >= 0 && keys_[table_[at]] != key) at = (at + 1) & mask_;
    if (table_[at] < 0) {
      table_[at] = static_cast<int>(keys_.size());
      keys_.push_back(key);
      begin_.push_back(0);
    }
    cell_of[i] = table_[at];
    ++begin_[cell_of[i]];
  }
  begin_.push_back(0);
  int sum = 0;
  for (int& b : begin_) sum += std::exchange(b, sum);
  order_.resize(points.size());
  sorted_.resize(points.size());
  std::vector<int> next(begin_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = static_cast<std::size_t>(next[cell_of[i]]++);
    order_[at] = static_cast<int>(i);
    sorted_[at] = points[i];
  }
}

PointCells::Found PointCells::nearest(const Vec3& p, double radius) const {
  Found best;
  double most = radius * radius;
  const Key center = key_of(p);
  const auto look = [&](const Key& key) {
    const int slot = find(key);
    if (slot < 0) return;
    for (int k = begin_[slot]; k < begin_[static_cast<std::size_t>(slot) + 1]; ++k) {
      const double squared = (sorted_[k] - p).squaredNorm();
      const int index = order_[k];
      if (squared < most || (squared == most && (best.index < 0 || index < best.index))) {
        most = squared;
        best = {index, squared};
      }
    }
  };
  look(center);
  // Shells of cells around; what lies in shell s is at least s - 1 cells and the way to the border of its own cell
  // away.
  Vec3 to_low, to_high;
  for (int a = 0; a < 3; ++a) {
    to_low[a] = p[a] - static_cast<double>(center[a]) * cell_;
    to_high[a] = cell_ - to_low[a];
  }
  for (std::int64_t s = 1;; ++s) {
    const double before = static_cast<double>(s - 1) * cell_;
    if (before + std::min(to_low.minCoeff(), to_high.minCoeff()) > std::sqrt(most)) return best;
    for (std::int64_t z = -s; z <= s; ++z) {
      for (std::int64_t y = -s; y <= s; ++y) {
        const bool is_side = z == -s || z == s || y == -s || y == s;
        for (std::int64_t x = -s; x <= s; x += is_side ? 1 : 2 * s) {
          const auto gap = [&](std::int64_t d, int a) {
            return d == 0 ? 0.0 : (d < 0 ? to_low[a] : to_high[a]) + static_cast<double>(std::abs(d) - 1) * cell_;
          };
          const double gx = gap(x, 0), gy = gap(y, 1), gz = gap(z, 2);
          if (gx * gx + gy * gy + gz * gz > most) continue;
          look({center[0] + x, center[1] + y, center[2] + z});
        }
      }
    }
  }
}

}  // namespace patinate::capture
