#include "simulation/tracing/ray_tracer.h"

#include <algorithm>
#include <limits>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "simulation/tracing/bvh_builder.h"

namespace patinate::simulation {

namespace {

using namespace ray_types;
#include "simulation/tracing/four_lanes.inl"
#include "simulation/tracing/ray_kernel.inl"

}  // namespace

RayTracer::RayTracer(const Mesh& mesh) {
  if (mesh.triangles.empty()) return;
  const Box box = bounding_box(mesh);
  for (Eigen::Index a = 0; a < 3; ++a) center_[a] = static_cast<double>(static_cast<float>(box.center()[a]));
  std::vector<RoundedTriangle> triangles(mesh.triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 p = mesh.positions[mesh.triangles[t][c]] - center_;
      for (std::size_t a = 0; a < 3; ++a) triangles[t][c][a] = static_cast<float>(p[static_cast<Eigen::Index>(a)]);
      const Vec3 rounded(static_cast<double>(triangles[t][c][0]), static_cast<double>(triangles[t][c][1]),
                         static_cast<double>(triangles[t][c][2]));
      box_.low = box_.low.cwiseMin(rounded + center_);
      box_.high = box_.high.cwiseMax(rounded + center_);
    }
  }
  // Coordinates relative to the middle are below half the diagonal; a difference of two of them, sheared by at most 1,
  // is off by less than 16 roundings of that.
  frame_.slack =
      std::max(static_cast<float>(0.5 * box_.diagonal() * 16.0 * 0x1.0p-24), std::numeric_limits<float>::min());
  for (Eigen::Index a = 0; a < 3; ++a) {
    const double margin = 2.0 * static_cast<double>(frame_.slack);
    frame_.center[a] = center_[a];
    frame_.low[a] = box_.low[a] - center_[a] - margin;
    frame_.high[a] = box_.high[a] - center_[a] + margin;
  }
  Bvh bvh = build_bvh(triangles, frame_.slack);
  nodes_ = std::move(bvh.nodes);
  blocks_ = std::move(bvh.blocks);
}

TriangleHit RayTracer::first_hit_of_all(const Vec3& origin, const Vec3& direction, double min_distance,
                                        double max_distance) const {
  TriangleHit best{.distance = max_distance};
  if (!is_usable(origin.data(), direction.data())) return {};
  const Shear shear = shear_of(direction.data());
  const Vec3 from = origin - center_;
  for (const TriangleBlock& block : blocks_) {
    for (std::uint32_t lane = 0; lane < 4; ++lane) {
      if (block.triangle[lane] >= 0) (void)hits(&block, lane, from.data(), &shear, min_distance, &best);
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
      for (const std::int32_t triangle : blocks_[-1 - at].triangle) {
        if (triangle >= 0 && stops(triangle)) return false;
      }
      continue;
    }
    const BvhNode& n = nodes_[at];
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
  if (nodes_.empty()) return {};
  return first_hit_along(&frame_, nodes_.data(), blocks_.data(), origin.data(), direction.data(), min_distance,
                         max_distance);
}

}  // namespace patinate::simulation
