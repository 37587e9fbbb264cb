#include "capture/registration/surfels.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/registration/point_cells.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr std::size_t kFewestPoints = 16;  ///< Fewer points make no surface.
constexpr int kMinOfAPlane = 6;            ///< A plane has three unknowns; twice as many points.
constexpr double kMaxThickness = 0.3;      ///< Smallest over middle eigenvalue; 1 = a ball.
constexpr double kMaxNarrowness = 0.08;    ///< Middle over largest; a line has 0.
constexpr double kBorderShift =
    0.22;  ///< Mean of the points off the middle, in radii; 0.32 for half a disc with these weights.
constexpr std::int64_t kCentersAChunk = 512;

/// Points that lie at least `distance` from those taken before them.
std::vector<int> spread_points(std::span<const Vec3> points, double distance) {
  // Taken points, at most a few a cell, linked.
  struct Cell {
    std::int64_t x, y, z;
    int first;
  };
  std::vector<int> taken, next;
  std::uint64_t size = 64;
  while (size < 2 * points.size()) size *= 2;
  std::vector<Cell> table(size, Cell{0, 0, 0, -1});
  const auto place = [&](std::int64_t x, std::int64_t y, std::int64_t z) -> Cell& {
    std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15u ^
                      static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4Fu ^
                      static_cast<std::uint64_t>(z) * 0x165667B19E3779F9u;
    h ^= h >> 29;
    for (h &= size - 1;; h = (h + 1) & (size - 1)) {
      Cell& c = table[h];
      if (c.first < 0 || (c.x == x && c.y == y && c.z == z)) return c;
    }
  };
  const double squared = distance * distance;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i];
    const Vec3 at = p / distance;
    const auto x = static_cast<std::int64_t>(std::floor(at.x())), y = static_cast<std::int64_t>(std::floor(at.y())),
               z = static_cast<std::int64_t>(std::floor(at.z()));
    const auto is_taken = [&](std::int64_t dx, std::int64_t dy, std::int64_t dz) {
      for (int k = place(x + dx, y + dy, z + dz).first; k >= 0; k = next[k]) {
        if ((points[taken[static_cast<std::size_t>(k)]] - p).squaredNorm() < squared) return true;
      }
      return false;
    };
    bool is_near = is_taken(0, 0, 0);
    // A neighbor cell that is farther away than the distance holds nothing near.
    const Vec3 low = at - Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
    const auto gap = [&](std::int64_t d, int a) { return d == 0 ? 0.0 : d < 0 ? low[a] : 1.0 - low[a]; };
    for (std::int64_t dz = -1; !is_near && dz <= 1; ++dz) {
      for (std::int64_t dy = -1; !is_near && dy <= 1; ++dy) {
        for (std::int64_t dx = -1; !is_near && dx <= 1; ++dx) {
          if (dx == 0 && dy == 0 && dz == 0) continue;
          const double gx = gap(dx, 0), gy = gap(dy, 1), gz = gap(dz, 2);
          if (gx * gx + gy * gy + gz * gz <= 1.0) is_near = is_taken(dx, dy, dz);
        }
      }
    }
    if (is_near) continue;
    Cell& cell = place(x, y, z);
    next.push_back(cell.first);
    cell = {x, y, z, static_cast<int>(taken.size())};
    taken.push_back(static_cast<int>(i));
  }
  return taken;
}

std::optional<Surfel> surfel_at(const PointCells& cells, std::span<const Vec3> points, int center, double radius) {
  const Vec3& p = points[center];
  double sum = 0.0, sum_squared = 0.0;
  int count = 0;
  Vec3 mean = Vec3::Zero();
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
  const double per_squared = 1.0 / (radius * radius);
  cells.near(p, radius, [&](int i, double squared) {
    const double w = 1.0 - squared * per_squared;
    const Vec3 d = points[i] - p;
    const Vec3 wd = w * d;
    sum += w;
    sum_squared += w * w;
    ++count;
    mean += wd;
    xx += wd.x() * d.x();
    xy += wd.x() * d.y();
    xz += wd.x() * d.z();
    yy += wd.y() * d.y();
    yz += wd.y() * d.z();
    zz += wd.z() * d.z();
  });
  if (count < kMinOfAPlane || !(sum > 0.0)) return std::nullopt;
  mean /= sum;
  Eigen::Matrix3d covariance;
  covariance << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  covariance = covariance / sum - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Vec3 values = solver.eigenvalues();
  if (!(values[0] < kMaxThickness * values[1]) || !(values[1] > kMaxNarrowness * values[2])) return std::nullopt;
  Surfel s;
  s.normal = solver.eigenvectors().col(0).normalized();
  const double off = s.normal.dot(mean);
  s.position = p + off * s.normal;
  s.num_points = sum * sum / sum_squared;
  s.variance = std::max(values[0], 1e-24 * values[2]) * s.num_points / std::max(1.0, s.num_points - 3.0);
  s.point = center;
  s.is_border = (mean - off * s.normal).norm() > kBorderShift * radius;
  return s;
}

}  // namespace

double point_spacing(std::span<const Vec3> points) {
  if (points.size() < kFewestPoints) {
    throw InvalidInput("registration: a scan has " + std::to_string(points.size()) + " points; at least " +
                       std::to_string(kFewestPoints) + " are needed");
  }
  Box box;
  for (const Vec3& p : points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  if (!(box.diagonal() > 0.0)) throw InvalidInput("registration: all points of a scan are the same");
  constexpr std::size_t kSample = 400;  // Points that the spacing is measured at, evenly picked.
  constexpr std::size_t kNth = 8;       // The spacing is derived from the distance to the eighth neighbor.
  const std::size_t step = std::max<std::size_t>(1, points.size() / kSample);
  double cell = 2.0 * box.diagonal() / std::sqrt(static_cast<double>(points.size()));
  const PointCells cells(points, cell);
  std::vector<double> eighth, near;
  for (std::size_t i = 0; i < points.size(); i += step) {
    for (double radius = cell;; radius *= 2.0) {
      near.clear();
      cells.near(points[i], radius, [&](int j, double squared) {
        if (static_cast<std::size_t>(j) != i && squared > 0.0) near.push_back(squared);
      });
      if (near.size() < kNth && radius < 2.0 * box.diagonal()) continue;
      if (near.size() >= kNth) {
        eighth.push_back(value_at_rank(near, kNth - 1));
      }
      break;
    }
  }
  if (eighth.empty()) throw InvalidInput("registration: a scan has fewer than 9 different points");
  return std::sqrt(median(std::move(eighth)) * 3.14159265358979323846 / static_cast<double>(kNth));
}

Surfels make_surfels(std::span<const Vec3> points, std::span<const Vec3> toward, double distance, double radius,
                     const RunControl& control) {
  const std::vector<int> centers = spread_points(points, distance);
  const PointCells cells(points, radius);
  std::vector<std::optional<Surfel>> found(centers.size());
  const RunControl quiet = control.silent();
  parallel_for(static_cast<std::int64_t>(centers.size()), kCentersAChunk, quiet,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                   found[i] = surfel_at(cells, points, centers[i], radius);
                   if (!found[i] || toward.empty()) continue;
                   if (found[i]->normal.dot(toward[centers[i]]) < 0.0) found[i]->normal = -found[i]->normal;
                 }
               });
  Surfels result;
  result.num_places = static_cast<int>(centers.size());
  for (const std::optional<Surfel>& s : found) {
    if (s) result.surfels.push_back(*s);
  }
  return result;
}

}  // namespace patinate::capture
