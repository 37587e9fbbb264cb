#include "simulation/tracing/ray_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulation/tracing/bvh_builder.h"
#include "simulation/tracing/lanes.h"

namespace patinate::simulation {

namespace {

constexpr std::size_t kStackSize = 512;  // 3 a level; Builder keeps trees below 40 + 31 levels

/// A ray in the form that blocks need: permuted so that its direction's largest part comes third, sheared onto that
/// axis.
struct Shear {
  std::array<std::size_t, 3> axis{};  ///< kx, ky, kz.
  double x = 0.0, y = 0.0, z = 0.0;
};

Shear shear_of(const Vec3& d) {
  std::size_t z = 0;
  if (std::abs(d.y()) > std::abs(d.x())) z = 1;
  if (std::abs(d.z()) > std::abs(d[static_cast<Eigen::Index>(z)])) z = 2;
  std::size_t x = (z + 1) % 3, y = (z + 2) % 3;
  const double inverse = 1.0 / d[static_cast<Eigen::Index>(z)];
  if (inverse < 0.0) std::swap(x, y);  // keeps the winding
  return {.axis = {x, y, z},
          .x = d[static_cast<Eigen::Index>(x)] * inverse,
          .y = d[static_cast<Eigen::Index>(y)] * inverse,
          .z = inverse};
}

/// One triangle, in double. Signs of u, v, w are right or zero, since rounding keeps the order of the two products.
bool hits(const TriangleBlock& block, std::size_t lane, const Vec3& origin, const Shear& s, double min_distance,
          TriangleHit& best) {
  std::array<double, 3> x, y, z;
  for (std::size_t c = 0; c < 3; ++c) {
    z[c] = static_cast<double>(block.corner[c][s.axis[2]][lane]) - origin[static_cast<Eigen::Index>(s.axis[2])];
    x[c] = static_cast<double>(block.corner[c][s.axis[0]][lane]) - origin[static_cast<Eigen::Index>(s.axis[0])] -
           s.x * z[c];
    y[c] = static_cast<double>(block.corner[c][s.axis[1]][lane]) - origin[static_cast<Eigen::Index>(s.axis[1])] -
           s.y * z[c];
  }
  const double u = x[2] * y[1] - y[2] * x[1];
  const double v = x[0] * y[2] - y[0] * x[2];
  const double w = x[1] * y[0] - y[1] * x[0];
  if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return false;
  const double det = u + v + w;
  if (det == 0.0) return false;
  const double distance = s.z * (u * z[0] + v * z[1] + w * z[2]) / det;
  const int triangle = block.triangle[lane];
  if (!(distance > min_distance) || distance > best.distance ||
      (distance == best.distance && best.triangle >= 0 && triangle >= best.triangle))
    return false;
  best = {.triangle = triangle, .b1 = v / det, .b2 = w / det, .distance = distance, .is_front = det > 0.0};
  return true;
}

/// Asks for two lines of memory that will be needed soon.
inline void prefetch([[maybe_unused]] const void* p) {
#if defined(__GNUC__)
  __builtin_prefetch(p);
  __builtin_prefetch(static_cast<const char*>(p) + 64);
#endif
}

float safe_inverse(double d) {
  const double least = 1e-30;
  return static_cast<float>(1.0 / (std::abs(d) < least ? std::copysign(least, d) : d));
}

float rounded_up(double x) {
  const double wide = x * (1.0 + 1e-6);
  return wide > 3e38 ? 3e38F : static_cast<float>(wide);
}

bool is_usable(const Vec3& origin, const Vec3& direction) {
  const double sum = origin.x() + origin.y() + origin.z() + direction.x() + direction.y() + direction.z();
  const double square = direction.squaredNorm();
  return sum - sum == 0.0 && square > 1e-200 && square < 1e200;
}

}  // namespace

RayTracer::RayTracer(const Mesh& mesh) {
  if (mesh.triangles.empty()) return;
  const Box box = bounding_box(mesh);
  for (Eigen::Index a = 0; a < 3; ++a) center_[a] = static_cast<double>(static_cast<float>(box.center()[a]));
  std::vector<RoundedTriangle> triangles(mesh.triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 p = mesh.positions[static_cast<std::size_t>(mesh.triangles[t][c])] - center_;
      for (std::size_t a = 0; a < 3; ++a) triangles[t][c][a] = static_cast<float>(p[static_cast<Eigen::Index>(a)]);
      const Vec3 rounded(static_cast<double>(triangles[t][c][0]), static_cast<double>(triangles[t][c][1]),
                         static_cast<double>(triangles[t][c][2]));
      box_.low = box_.low.cwiseMin(rounded + center_);
      box_.high = box_.high.cwiseMax(rounded + center_);
    }
  }
  // Coordinates relative to the middle are below half the diagonal; a difference of two of them, sheared by at most 1,
  // is off by less than 16 roundings of that.
  slack_ = std::max(static_cast<float>(0.5 * box_.diagonal() * 16.0 * 0x1.0p-24), std::numeric_limits<float>::min());
  low_ = box_.low - center_ - Vec3::Constant(2.0 * static_cast<double>(slack_));
  high_ = box_.high - center_ + Vec3::Constant(2.0 * static_cast<double>(slack_));
  Bvh bvh = build_bvh(triangles, slack_);
  nodes_ = std::move(bvh.nodes);
  blocks_ = std::move(bvh.blocks);
}

TriangleHit RayTracer::first_hit_of_all(const Vec3& origin, const Vec3& direction, double min_distance,
                                        double max_distance) const {
  TriangleHit best{.distance = max_distance};
  if (!is_usable(origin, direction)) return {};
  const Shear shear = shear_of(direction);
  for (const TriangleBlock& block : blocks_) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      if (block.triangle[lane] >= 0) (void)hits(block, lane, origin - center_, shear, min_distance, best);
    }
  }
  return best.triangle >= 0 ? best : TriangleHit{};
}

bool RayTracer::none_in_box(const Box& box, const std::function<bool(int)>& stops) const {
  if (nodes_.empty()) return true;
  const Vec3 low = box.low - center_, high = box.high - center_;
  std::vector<std::int32_t> stack{0};
  while (!stack.empty()) {
    const std::int32_t at = stack.back();
    stack.pop_back();
    if (at < 0) {
      for (const std::int32_t triangle : blocks_[static_cast<std::size_t>(-1 - at)].triangle) {
        if (triangle >= 0 && stops(triangle)) return false;
      }
      continue;
    }
    const BvhNode& n = nodes_[static_cast<std::size_t>(at)];
    for (std::size_t lane = 0; lane < 4; ++lane) {
      bool meets = n.bounds[0][0][lane] <= n.bounds[1][0][lane];
      for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        meets = meets && static_cast<double>(n.bounds[0][a][lane]) <= high[axis] &&
                static_cast<double>(n.bounds[1][a][lane]) >= low[axis];
      }
      if (meets) stack.push_back(n.child[lane]);
    }
  }
  return true;
}

TriangleHit RayTracer::first_hit(const Vec3& origin, const Vec3& direction, double min_distance,
                                 double max_distance) const {
  if (nodes_.empty() || !is_usable(origin, direction)) return {};
  const Vec3 o = origin - center_;
  double begin = min_distance, end = max_distance;
  if (!((o - low_).minCoeff() >= 0.0 && (high_ - o).minCoeff() >= 0.0)) {
    // The part of the ray inside the box, so that float numbers do not grow with the distance of the origin.
    for (Eigen::Index a = 0; a < 3; ++a) {
      const double low = low_[a] - o[a], high = high_[a] - o[a];
      if (direction[a] == 0.0) {
        if (low > 0.0 || high < 0.0) return {};
        continue;
      }
      const double t0 = low / direction[a], t1 = high / direction[a];
      begin = std::max(begin, std::min(t0, t1));
      end = std::min(end, std::max(t0, t1));
    }
    if (!(begin <= end)) return {};
  }
  const double shift = begin > min_distance ? begin : 0.0;
  const Vec3 near = o + shift * direction;
  const Shear shear = shear_of(direction);
  RayLanes ray(near, direction, shear.axis, shear.x, shear.y, shear.z, slack_);
  for (Eigen::Index a = 0; a < 3; ++a) ray.set_inverse(static_cast<std::size_t>(a), safe_inverse(direction[a]));
  const float from = std::max(0.0F, static_cast<float>((min_distance - shift) * (1.0 - 1e-6)));
  float to = rounded_up(end - shift);
  ray.set_interval(from, to);

  struct Entry {
    std::int32_t node;
    float distance;
  };
  std::array<Entry, kStackSize> stack;
  std::size_t size = 0;
  TriangleHit best{.distance = max_distance};
  std::int32_t node = 0;
  while (true) {
    if (node >= 0) {
      const BvhNode& n = nodes_[static_cast<std::size_t>(node)];
      alignas(16) std::array<float, 4> distance;
      unsigned hit = ray.boxes_hit(n, distance);
      if (hit != 0) {
        // Children from far to near onto the stack: at most four, sorted as they come.
        const std::size_t first = size;
        for (; hit != 0; hit &= hit - 1) {
          const auto lane = static_cast<std::size_t>(std::countr_zero(hit));
          std::size_t at = size++;
          for (; at > first && stack[at - 1].distance < distance[lane]; --at) stack[at] = stack[at - 1];
          const std::int32_t child = n.child[lane];
          stack[at] = {child, distance[lane]};
          if (child >= 0) {
            prefetch(&nodes_[static_cast<std::size_t>(child)]);
          } else {
            prefetch(&blocks_[static_cast<std::size_t>(-1 - child)]);
          }
        }
        node = stack[--size].node;
        continue;
      }
    } else {
      const TriangleBlock& block = blocks_[static_cast<std::size_t>(-1 - node)];
      bool is_nearer = false;
      for (unsigned maybe = ray.triangles_maybe_hit(block); maybe != 0; maybe &= maybe - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(maybe));
        if (block.triangle[lane] >= 0) is_nearer |= hits(block, lane, o, shear, min_distance, best);
      }
      if (is_nearer) {
        to = std::min(to, rounded_up(best.distance - shift));
        ray.set_interval(from, to);
      }
    }
    do {
      if (size == 0) return best.triangle >= 0 ? best : TriangleHit{};
      --size;
    } while (stack[size].distance > to);
    node = stack[size].node;
  }
}

}  // namespace patinate::simulation
