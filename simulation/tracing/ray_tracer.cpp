#include "simulation/tracing/ray_tracer.h"

#include <emmintrin.h>

#include <algorithm>
#include <limits>
#include <vector>

#ifdef __SSE2__
#endif

namespace patinate::simulation {

namespace {

struct Bvh {
  std::vector<BvhNode> nodes;
  std::vector<TriangleBlock> blocks;
};

using RoundedTriangle = std::array<std::array<float, 3>, 3>;  ///< [corner][axis].

constexpr int kBins = 16;  ///< Bins of the surface area heuristic; speed alone.
constexpr int kLanes = 4;  ///< Children of a node, tested as lanes of one vector.
constexpr int kMaxSahDepth =
    40;  // deeper ones are halved, so that no mesh makes a chain that overflows a traversal's stack

struct FloatBox {
  std::array<float, 3> low{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                           std::numeric_limits<float>::infinity()};
  std::array<float, 3> high{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()};

  void add(const FloatBox& other) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], other.low[a]);
      high[a] = std::max(high[a], other.high[a]);
    }
  }
  [[nodiscard]] float half_area() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x < 0.0F ? 0.0F : x * y + y * z + z * x;
  }
};

FloatBox box_of(const RoundedTriangle& t) {
  FloatBox box;
  for (const auto& corner : t) box.add({.low = corner, .high = corner});
  return box;
}

/// Twice the middle of a box along an axis.
float middle(const FloatBox& box, std::size_t axis) { return box.low[axis] + box.high[axis]; }

struct BinaryNode {
  FloatBox box;
  int left = -1;  ///< -1: a leaf.
  int right = -1;
  int begin = 0;
  int end = 0;
};

class Builder {
 public:
  Builder(const std::vector<RoundedTriangle>& triangles, float slack) : triangles_(triangles), slack_(slack) {
    boxes_.reserve(triangles.size());
    for (const RoundedTriangle& t : triangles) boxes_.push_back(box_of(t));
    order_.resize(triangles.size());
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<int>(i);
  }

  Bvh build() {
    Bvh bvh;
    if (triangles_.empty()) return bvh;
    const int root = split(0, static_cast<int>(order_.size()), 0);
    collapse(root, bvh);
    return bvh;
  }

 private:
  struct Split {
    float cost = std::numeric_limits<float>::infinity();
    std::size_t axis = 0;
    int bin = 0;  ///< First bin of the right part.
  };

  [[nodiscard]] const FloatBox& box_at(int i) const { return boxes_[order_[static_cast<std::size_t>(i)]]; }

  static int bin_of(float value, float low, float scale) {
    return std::clamp(static_cast<int>((value - low) * scale), 0, kBins - 1);
  }

  [[nodiscard]] Split best_split(int begin, int end, const FloatBox& middles) const {
    Split best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float extent = middles.high[axis] - middles.low[axis];
      if (!(extent > 0.0F)) continue;
      const float scale = static_cast<float>(kBins) / extent;
      std::array<FloatBox, kBins> bins;
      std::array<int, kBins> counts{};
      for (int i = begin; i < end; ++i) {
        const auto b = static_cast<std::size_t>(bin_of(middle(box_at(i), axis), middles.low[axis], scale));
        bins[b].add(box_at(i));
        ++counts[b];
      }
      std::array<float, kBins> right_cost{};
      FloatBox box;
      int count = 0;
      for (std::size_t b = kBins - 1; b > 0; --b) {
        box.add(bins[b]);
        count += counts[b];
        right_cost[b] =
            count > 0 ? box.half_area() * static_cast<float>(count) : std::numeric_limits<float>::infinity();
      }
      box = {};
      count = 0;
      for (std::size_t b = 1; b < kBins; ++b) {
        box.add(bins[b - 1]);
        count += counts[b - 1];
        if (count == 0) continue;
        const float cost = box.half_area() * static_cast<float>(count) + right_cost[b];
        if (cost < best.cost) best = {.cost = cost, .axis = axis, .bin = static_cast<int>(b)};
      }
    }
    return best;
  }

  /// Orders [begin, end) into two parts and says where the second one begins.
  int partition(int begin, int end, int depth) {
    FloatBox middles;
    for (int i = begin; i < end; ++i) {
      const FloatBox& box = box_at(i);
      const std::array<float, 3> m{middle(box, 0), middle(box, 1), middle(box, 2)};
      middles.add({.low = m, .high = m});
    }
    const int half = begin + (end - begin) / 2;
    if (depth >= kMaxSahDepth) return half;
    const Split best = best_split(begin, end, middles);
    if (!(best.cost < std::numeric_limits<float>::infinity())) return half;  // all middles are one
    const float low = middles.low[best.axis];
    const float scale = static_cast<float>(kBins) / (middles.high[best.axis] - low);
    std::vector<int> right;
    auto to = order_.begin() + begin;
    for (int i = begin; i < end; ++i) {
      const int t = order_[i];
      if (bin_of(middle(box_at(i), best.axis), low, scale) < best.bin) {
        *to++ = t;
      } else {
        right.push_back(t);
      }
    }
    const int border = static_cast<int>(to - order_.begin());
    std::copy(right.begin(), right.end(), to);
    return border > begin && border < end ? border : half;
  }

  int split(int begin, int end, int depth) {
    const auto index = binary_.size();
    binary_.emplace_back();
    BinaryNode node{.box = {}, .begin = begin, .end = end};
    for (int i = begin; i < end; ++i) node.box.add(box_at(i));
    if (end - begin > kLanes) {
      const int border = partition(begin, end, depth);
      node.left = split(begin, border, depth + 1);
      node.right = split(border, end, depth + 1);
    }
    binary_[index] = node;
    return static_cast<int>(index);
  }

  std::int32_t make_block(const BinaryNode& leaf, Bvh& bvh) const {
    TriangleBlock block{};
    for (int lane = 0; lane < kLanes; ++lane) {
      const bool is_used = leaf.begin + lane < leaf.end;
      const int triangle = order_[is_used ? leaf.begin + lane : leaf.begin];
      const auto l = static_cast<std::size_t>(lane);
      block.triangle[l] = is_used ? triangle : -1;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        for (std::size_t axis = 0; axis < 3; ++axis) block.corner[corner][axis][l] = triangles_[triangle][corner][axis];
      }
    }
    bvh.blocks.push_back(block);
    return -static_cast<std::int32_t>(bvh.blocks.size());
  }

  /// Opens the largest boxes of a binary node until there are four children, in the order of the mesh's halves.
  std::int32_t collapse(int root, Bvh& bvh) const {
    const auto index = bvh.nodes.size();
    bvh.nodes.emplace_back();
    std::vector<int> children{root};
    while (static_cast<int>(children.size()) < kLanes) {
      float largest = -1.0F;
      std::size_t chosen = 0;
      for (std::size_t i = 0; i < children.size(); ++i) {
        const BinaryNode& c = binary_[children[i]];
        if (c.left >= 0 && c.box.half_area() > largest) {
          largest = c.box.half_area();
          chosen = i;
        }
      }
      if (largest < 0.0F) break;
      const BinaryNode& opened = binary_[children[chosen]];
      children[chosen] = opened.left;
      children.insert(children.begin() + static_cast<std::ptrdiff_t>(chosen) + 1, opened.right);
    }
    BvhNode node{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (lane >= children.size()) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          node.bounds[0][axis][lane] = std::numeric_limits<float>::max();
          node.bounds[1][axis][lane] = -std::numeric_limits<float>::max();
        }
        continue;
      }
      const BinaryNode& c = binary_[children[lane]];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.bounds[0][axis][lane] = c.box.low[axis] - slack_;
        node.bounds[1][axis][lane] = c.box.high[axis] + slack_;
      }
      node.child[lane] = c.left >= 0 ? collapse(children[lane], bvh) : make_block(c, bvh);
    }
    bvh.nodes[index] = node;
    return static_cast<std::int32_t>(index);
  }

  const std::vector<RoundedTriangle>& triangles_;
  float slack_;
  std::vector<FloatBox> boxes_;
  std::vector<int> order_;
  std::vector<BinaryNode> binary_;
};

/// Top down: the cheapest of 16 bins' borders along each axis by surface area [Wald 2007], down to four triangles, then
/// pairs of levels are joined. The same for the same triangles, always.
/// @param slack  All boxes are grown by this.
/// Cost: O(n log n); 0.1 us per triangle and level.
Bvh build_bvh(const std::vector<RoundedTriangle>& triangles, float slack) { return Builder(triangles, slack).build(); }

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
