#include "simulation/tracing/clearance.h"

#include <Eigen/Geometry>
#include <array>

#include "libcommon/core/parallel.h"

namespace patinate::simulation {

namespace {

/// Coordinates in a triangle's prism: barycentric weights of its corners, and the height above it.
struct PrismPoint {
  std::array<double, 3> b;
  double height;
};

/// A convex polygon: a triangle cut by five planes has at most eight corners.
struct Polygon {
  std::array<PrismPoint, 12> corner;
  std::size_t size = 0;
};

/// What is left of a polygon where value(corner) >= 0.
template <class Value>
Polygon cut(const Polygon& polygon, Value&& value) {
  Polygon left;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const PrismPoint& p = polygon.corner[i];
    const PrismPoint& q = polygon.corner[(i + 1) % polygon.size];
    const double a = value(p), b = value(q);
    if (a >= 0.0) left.corner[left.size++] = p;
    if ((a < 0.0) == (b < 0.0)) continue;
    const double s = a / (a - b);
    PrismPoint between{};
    for (std::size_t k = 0; k < 3; ++k) between.b[k] = p.b[k] + s * (q.b[k] - p.b[k]);
    between.height = p.height + s * (q.height - p.height);
    left.corner[left.size++] = between;
  }
  return left;
}

constexpr double kInside =
    0.5e-6;  // half of what moved_inside() keeps from edges: walls that stand on an edge do not cut
constexpr double kLowest = 1e-3;  // of the height: what lies in the triangle's own plane is not above it

}  // namespace

Clearance::Clearance(const RayTracer& rays, const TriangleFrames& frames, int num_triangles, double height_mm)
    : rays_(&rays),
      frames_(&frames),
      num_triangles_(num_triangles),
      height_(height_mm),
      known_(std::make_unique<std::atomic<std::uint8_t>[]>(static_cast<std::size_t>(num_triangles) * 2)) {}

std::vector<std::uint8_t> Clearance::all(const RunControl& control) {
  std::vector<std::uint8_t> clear(static_cast<std::size_t>(num_triangles_) * 2);
  parallel_for(num_triangles_, 256, control, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<int>(begin); t < end; ++t) {
      for (const int side : {0, 1}) clear[2 * t + side] = is_clear(t, side == 0) ? std::uint8_t{1} : std::uint8_t{0};
    }
  });
  return clear;
}

bool Clearance::find(int triangle, bool is_front) const {
  const Vec3 a = frames_->corner(triangle, 0), e1 = frames_->corner(triangle, 1) - a,
             e2 = frames_->corner(triangle, 2) - a;
  const Vec3 area = e1.cross(e2);
  const double square = area.squaredNorm();
  if (!(square > 0.0)) return false;
  const Vec3 up = (is_front ? 1.0 : -1.0) / std::sqrt(square) * area;
  const Vec3 gradient_1 = e2.cross(area) / square, gradient_2 = area.cross(e1) / square;
  const double top = 1.001 * height_;
  Box box;
  for (const Vec3& p : {a, Vec3(a + e1), Vec3(a + e2)}) {
    box.low = box.low.cwiseMin(p).cwiseMin(p + top * up);
    box.high = box.high.cwiseMax(p).cwiseMax(p + top * up);
  }
  return rays_->none_in_box(box, [&](int other) {
    if (other == triangle) return false;
    Polygon polygon{.corner = {}, .size = 3};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = frames_->corner(other, k) - a;
      const double b1 = p.dot(gradient_1), b2 = p.dot(gradient_2);
      polygon.corner[k] = {.b = {1.0 - b1 - b2, b1, b2}, .height = p.dot(up)};
    }
    for (std::size_t k = 0; k < 3; ++k) polygon = cut(polygon, [&](const PrismPoint& p) { return p.b[k] - kInside; });
    polygon = cut(polygon, [&](const PrismPoint& p) { return p.height - kLowest * height_; });
    polygon = cut(polygon, [&](const PrismPoint& p) { return top - p.height; });
    return polygon.size > 0;
  });
}

}  // namespace patinate::simulation
