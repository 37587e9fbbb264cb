#include "simulation/tracing/free_space.h"

#include <algorithm>
#include <cmath>

namespace patinate::simulation {

namespace {
constexpr int kMaxCells = 64;  ///< Cells along a side of the grid.
constexpr int kFar = 255;      ///< Largest distance that a byte holds, cells.

/// Distances in the maximum norm, half of them: over neighbors that come before a cell, in the given order [Rosenfeld
/// and Pfaltz 1966].
void spread(std::vector<std::uint8_t>& distance, const std::array<int, 3>& size, int step) {
  const auto first = [&](int n) { return step > 0 ? 0 : n - 1; };
  for (int z = first(size[2]); z >= 0 && z < size[2]; z += step) {
    for (int y = first(size[1]); y >= 0 && y < size[1]; y += step) {
      for (int x = first(size[0]); x >= 0 && x < size[0]; x += step) {
        const auto index = [&](int i, int j, int k) {
          return static_cast<std::size_t>((k * size[1] + j) * size[0] + i);
        };
        int least = distance[index(x, y, z)];
        for (int k = -1; k <= 1; ++k) {
          for (int j = -1; j <= 1; ++j) {
            for (int i = -1; i <= 1; ++i) {
              if (k * 9 + j * 3 + i >= 0) continue;
              const int nx = x + step * i, ny = y + step * j, nz = z + step * k;
              if (nx < 0 || ny < 0 || nz < 0 || nx >= size[0] || ny >= size[1] || nz >= size[2]) continue;
              least = std::min(least, distance[index(nx, ny, nz)] + 1);
            }
          }
        }
        distance[index(x, y, z)] = static_cast<std::uint8_t>(least);
      }
    }
  }
}

}  // namespace

FreeSpace::FreeSpace(const RayTracer& rays) {
  if (rays.nodes().empty()) return;
  const Box& box = rays.box();
  const double margin = 4e-3 * box.diagonal() + 4e-6;  // more than flight leaves around the box
  const Vec3 extent = box.high - box.low + Vec3::Constant(2.0 * margin);
  const Vec3 low = box.low - Vec3::Constant(margin);
  const double cell = extent.maxCoeff() / kMaxCells, inverse = 1.0 / cell;
  std::array<int, 3> size{};
  for (std::size_t a = 0; a < 3; ++a)
    size[a] = std::max(1, static_cast<int>(std::ceil(extent[static_cast<Eigen::Index>(a)] * inverse)));
  facts_ = {.low = vector_of(low), .cell = cell, .inverse_cell = inverse, .size = {size[0], size[1], size[2]}};
  // Distances to the nearest cell with a triangle's box in it, in the maximum norm: one axis after the other.
  std::vector<std::uint8_t> distance(
      static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]), kFar);
  for (const TriangleBlock& block : rays.blocks()) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      std::array<int, 3> from{}, to{};
      for (std::size_t a = 0; a < 3; ++a) {
        const auto& c = block.corner;
        const double origin = rays.center()[static_cast<Eigen::Index>(a)] - low[static_cast<Eigen::Index>(a)];
        const double lowest =
            static_cast<double>(std::min({c[0][a][lane], c[1][a][lane], c[2][a][lane]})) + origin - 0.25 * margin;
        const double highest =
            static_cast<double>(std::max({c[0][a][lane], c[1][a][lane], c[2][a][lane]})) + origin + 0.25 * margin;
        from[a] = std::clamp(static_cast<int>(lowest * inverse), 0, size[a] - 1);
        to[a] = std::clamp(static_cast<int>(highest * inverse), 0, size[a] - 1);
      }
      for (int z = from[2]; z <= to[2]; ++z) {
        for (int y = from[1]; y <= to[1]; ++y) {
          for (int x = from[0]; x <= to[0]; ++x) distance[(z * size[1] + y) * size[0] + x] = 0;
        }
      }
    }
  }
  spread(distance, size, 1);
  spread(distance, size, -1);
  // A neighbor at distance 1 may touch: empty all around are one less.
  empty_.resize(distance.size());
  for (std::size_t i = 0; i < distance.size(); ++i)
    empty_[i] = distance[i] > 0 ? static_cast<std::uint8_t>(distance[i] - 1) : std::uint8_t{0};
}

}  // namespace patinate::simulation
