#include "simulation/transport/surface_walk.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace patinate::simulation {

namespace {

constexpr std::size_t kNodes = SplatShape::kMaxParts;
static_assert(kNodes == transfer_kernel::kWalkTexels);
constexpr std::size_t kEdges = transfer_kernel::kWalkEdges;
constexpr int kDeepest = transfer_kernel::kDeepestWalk;

/// Texels around one by their distance in links, and the links between them.
class Neighborhood {
 public:
  /// @param depth      Links from the middle at most.
  /// @param num_steps  That step() will do: over links from farther away nothing goes.
  Neighborhood(const SurfaceAtlas& surface, TexelIndex middle, int depth, int num_steps, double share) {
    slots_.fill(0);
    (void)node_of(middle);
    std::array<SurfaceAtlas::Link, 4> plain;
    std::size_t begin = 0;
    for (int d = 0; d <= depth; ++d) {
      const std::size_t end = num_nodes_;
      level_end_[num_levels_++] = end;
      if (d >= num_steps) {
        first_edge_[begin] = num_edges_;
        break;
      }
      for (std::size_t i = begin; i < end; ++i) {
        first_edge_[i] = num_edges_;
        for (const SurfaceAtlas::Link& link : surface.links(texel_[i], plain)) {
          const std::size_t to = d < depth ? node_of(link.texel) : find(link.texel);
          if (to < kNodes && num_edges_ < kEdges) edges_[num_edges_++] = {to, share * flow(surface, texel_[i], link)};
        }
      }
      begin = end;
    }
    first_edge_[num_nodes_] = num_edges_;
  }

  [[nodiscard]] std::size_t size() const { return num_nodes_; }
  [[nodiscard]] TexelIndex texel(std::size_t node) const { return texel_[node]; }

  /// Step number `number`, from 0, of what began in the middle: it has come no further than that many links.
  void step(int number, std::array<double, kNodes>& share) const {
    const std::size_t there = end_of_level(number), reached = end_of_level(number + 1);
    std::array<double, kNodes> next;
    std::copy_n(share.begin(), reached, next.begin());
    for (std::size_t i = 0; i < there; ++i) {
      double stays = share[i], own = next[i];  // no link leads back to where it begins
      for (std::size_t e = first_edge_[i]; e < first_edge_[i + 1]; ++e) {
        const double goes = std::min(stays, share[i] * edges_[e].flow);
        stays -= goes;
        next[edges_[e].to] += goes;
        own -= goes;
      }
      next[i] = own;
    }
    std::copy_n(next.begin(), reached, share.begin());
  }

 private:
  /// Behind the last node that so many links lead to.
  [[nodiscard]] std::size_t end_of_level(int links) const {
    return level_end_[std::min(static_cast<std::size_t>(links), num_levels_ - 1)];
  }

  struct Edge {
    std::size_t to;
    double flow;
  };

  /// Flow over a link of what is on a texel, as a multiple of what goes between two whole texels.
  static double flow(const SurfaceAtlas& surface, TexelIndex from, const SurfaceAtlas::Link& link) {
    const std::uint32_t weight = surface.weight(from), other = surface.weight(link.texel);
    const std::uint32_t whole =
        surface.weight_of_triangle(surface.triangle(from)) + surface.weight_of_triangle(surface.triangle(link.texel));
    return transfer_kernel::link_flow(weight, other, whole, link.count);
  }
  static std::size_t slot_of(TexelIndex texel) { return (texel * 0x9E3779B1u >> 16) % kSlots; }
  /// kNodes where it is not among them.
  [[nodiscard]] std::size_t find(TexelIndex texel) const {
    for (std::size_t s = slot_of(texel); slots_[s] != 0; s = (s + 1) % kSlots) {
      if (texel_[slots_[s] - 1u] == texel) return slots_[s] - 1u;
    }
    return kNodes;
  }
  /// Made when there is room.
  [[nodiscard]] std::size_t node_of(TexelIndex texel) {
    std::size_t s = slot_of(texel);
    for (; slots_[s] != 0; s = (s + 1) % kSlots) {
      if (texel_[slots_[s] - 1u] == texel) return slots_[s] - 1u;
    }
    if (num_nodes_ == kNodes) return kNodes;
    texel_[num_nodes_] = texel;
    slots_[s] = static_cast<std::uint16_t>(++num_nodes_);
    return num_nodes_ - 1;
  }

  static constexpr std::size_t kSlots = 2048;
  std::array<std::uint16_t, kSlots> slots_;  ///< Node + 1.
  std::array<TexelIndex, kNodes> texel_;
  std::array<std::size_t, kNodes + 1> first_edge_;
  std::array<Edge, kEdges> edges_;
  std::array<std::size_t, kDeepest + 1> level_end_;  ///< Nodes that so many links lead to.
  std::size_t num_nodes_ = 0, num_edges_ = 0, num_levels_ = 0;
};

}  // namespace

void walk_surface(const SurfaceAtlas& surface, TexelIndex texel, int size, std::vector<SplatPart>& parts) {
  const WalkLength length = walk_length(size);
  const double least = transfer_kernel::least_of_walk(length.num_steps);
  const Neighborhood around(surface, texel, transfer_kernel::walk_depth(size, length.num_steps), length.num_steps,
                            length.share);
  std::array<double, kNodes> share;
  std::fill_n(share.begin(), around.size(), 0.0);
  share[0] = 1.0;
  for (int s = 0; s < length.num_steps; ++s) around.step(s, share);

  const double weight = surface.weight(texel);
  const auto is_counted = [&](std::size_t i) {
    return i == 0 || transfer_kernel::is_counted(share[i], weight, least, share[0], surface.weight(around.texel(i)));
  };
  double sum = 0.0;
  for (std::size_t i = 0; i < around.size(); ++i) sum += is_counted(i) ? share[i] : 0.0;
  const std::size_t middle = parts.size();
  std::uint32_t rest = SplatShape::kWhole;
  parts.push_back({texel, 0});
  for (std::size_t i = 1; i < around.size(); ++i) {
    if (!is_counted(i)) continue;
    const std::uint32_t whole = transfer_kernel::whole_share(share[i], sum);
    if (whole == 0) continue;
    parts.push_back({around.texel(i), whole});
    rest -= whole;
  }
  parts[middle].share = rest;
}

}  // namespace patinate::simulation
