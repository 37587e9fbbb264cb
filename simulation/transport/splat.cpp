#include "simulation/transport/splat.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <numeric>
#include <utility>

#include "simulation/transport/splat_kernel.h"
#include "simulation/transport/surface_walk.h"

namespace patinate::simulation {

namespace {

constexpr int kMaxSize = transfer_kernel::kMaxVariance;
constexpr int kReach = 15;  // texels that a stencil goes to each side

/// Shares that the walk leaves in a plane; the middle first. Alike under turns and reflections.
SplatStencil make_stencil(int size) {
  constexpr int kSide = 2 * kReach + 3;  // with a rim that is walked onto and not counted
  const auto at = [](int x, int y) { return static_cast<std::size_t>((y + kReach + 1) * kSide + x + kReach + 1); };
  std::vector<double> share(kSide * kSide, 0.0), next(share.size());
  share[at(0, 0)] = 1.0;
  const WalkLength walk = walk_length(size);
  for (int step = 0; step < walk.num_steps; ++step) {
    for (int y = -kReach; y <= kReach; ++y) {
      for (int x = -kReach; x <= kReach; ++x) {
        const double beside = (share[at(x - 1, y)] + share[at(x + 1, y)]) + (share[at(x, y - 1)] + share[at(x, y + 1)]);
        next[at(x, y)] = (1.0 - 4.0 * walk.share) * share[at(x, y)] + walk.share * beside;
      }
    }
    std::swap(share, next);
  }
  const double least = transfer_kernel::least_of_walk(walk.num_steps) * share[at(0, 0)];
  double sum = 0.0;
  for (const double s : share) sum += s >= least ? s : 0.0;
  SplatStencil stencil;
  stencil.parts.push_back({});
  std::uint32_t rest = SplatShape::kWhole;
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = -kReach; x <= kReach; ++x) {
      if ((x == 0 && y == 0) || share[at(x, y)] < least) continue;
      // The average with its mirror image makes rounding alike for both diagonals.
      const double s = 0.5 * (share[at(x, y)] + share[at(y, x)]);
      const auto whole = static_cast<std::uint32_t>(s / sum * SplatShape::kWhole);
      if (whole == 0) continue;  // a short walk does not come there
      stencil.parts.push_back({.x = static_cast<std::int8_t>(x), .y = static_cast<std::int8_t>(y), .share = whole});
      rest -= whole;
    }
  }
  stencil.parts[0].share = rest;
  stencil.reach = stencil.parts.size() > 1 ? -stencil.parts[1].y : 0;
  stencil.lay_lanes();
  return stencil;
}

}  // namespace

void SplatStencil::lay_lanes() {
  std::vector<std::uint32_t> until(parts.size() + 1, 0);
  for (std::size_t k = 0; k < parts.size(); ++k) until[k + 1] = until[k] + parts[k].share;
  std::vector<std::uint32_t> order(parts.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(parts[a].y, parts[a].x) < std::pair(parts[b].y, parts[b].x);
  });
  constexpr int kBlock = transport::kLaneBlock;
  num_lanes = (static_cast<int>(parts.size()) + kBlock - 1) / kBlock * kBlock;
  lane_of.resize(parts.size());
  // Behind the last part there is nothing left to share.
  number.assign(static_cast<std::size_t>(num_lanes), 0);
  before.assign(static_cast<std::size_t>(num_lanes), SplatShape::kWhole);
  after = before;
  for (std::size_t l = 0; l < order.size(); ++l) {
    const std::uint32_t k = order[l];
    const Part& part = parts[k];
    lane_of[k] = static_cast<std::uint16_t>(l);
    number[l] = k;
    before[l] = until[k];
    after[l] = until[k + 1];
    if (runs.empty() || runs.back().y != part.y || runs.back().x + runs.back().length != part.x)
      runs.push_back({.x = part.x, .y = part.y, .length = 0});
    ++runs.back().length;
  }
  middle = lane_of[0];
}

const SplatStencil& SplatShape::stencil_of(int size) {
  static constinit std::array<std::atomic<const SplatStencil*>, kMaxSize + 1> made{};
  const auto s = static_cast<std::size_t>(size);
  if (const SplatStencil* stencil = made[s].load(std::memory_order_acquire)) return *stencil;
  static std::array<SplatStencil, kMaxSize + 1> stencils;
  static std::array<std::once_flag, kMaxSize + 1> is_made;
  std::call_once(is_made[s], [&] {
    stencils[s] = make_stencil(size);
    made[s].store(&stencils[s], std::memory_order_release);
  });
  return stencils[s];
}

SplatShape::SplatShape(const SurfaceAtlas& surface, double width) : surface_(&surface), width_(width) {}

int SplatShape::size_of(std::uint32_t weight) const { return transfer_kernel::splat_variance(width_, weight); }

std::size_t SplatShape::append(TexelIndex texel, std::vector<SplatPart>& parts) const {
  const std::size_t first = parts.size();
  const int size = size_at(texel);
  if (size == 0) {
    parts.push_back({texel, kWhole});
  } else if (!append_stencil(texel, size, parts)) {
    walk_surface(*surface_, texel, size, parts);
  }
  return parts.size() - first;
}

void SplatShape::prefetch(TexelIndex texel) const {
  const TileGrid& grid = surface_->grid();
  const int x = grid.x(texel), y = grid.y(texel);
  surface_->prefetch(texel);
  if (x > 0) surface_->prefetch_weight(grid.index(x - 1, y));
  if (x + 1 < grid.width) surface_->prefetch_weight(grid.index(x + 1, y));
  if (y > 0) surface_->prefetch_weight(grid.index(x, y - 1));
  if (y + 1 < grid.height) surface_->prefetch_weight(grid.index(x, y + 1));
}

bool SplatShape::is_plain(int x, int y, int reach) const {
  const TileGrid& grid = surface_->grid();
  if (x < reach || y < reach || x + reach >= grid.width || y + reach >= grid.height) return false;
  constexpr int kSide = TileGrid::kTileSide;
  for (int ty = (y - reach) / kSide; ty <= (y + reach) / kSide; ++ty) {
    for (int tx = (x - reach) / kSide; tx <= (x + reach) / kSide; ++tx) {
      if (!surface_->is_plain(TileGrid::tile_of(grid.index(tx * kSide, ty * kSide)))) return false;
    }
  }
  return true;
}

/// @returns false, with nothing appended, where a seam or the surface's end is near.
bool SplatShape::append_stencil(TexelIndex texel, int size, std::vector<SplatPart>& parts) const {
  const SplatStencil& stencil = stencil_of(size);
  const TileGrid& grid = surface_->grid();
  const int x = grid.x(texel), y = grid.y(texel);
  if (!is_plain(x, y, stencil.reach)) return false;
  const std::uint32_t weight = surface_->weight(texel);
  const std::size_t middle = parts.size();
  std::uint32_t rest = kWhole;
  parts.push_back({texel, 0});
  for (std::size_t k = 1; k < stencil.parts.size(); ++k) {
    const SplatStencil::Part& part = stencil.parts[k];
    const TexelIndex there = grid.index(x + part.x, y + part.y);
    const std::uint32_t share = balanced(part.share, weight, surface_->weight(there));
    if (share == 0) continue;
    parts.push_back({there, share});
    rest -= share;
  }
  parts[middle].share = rest;
  return true;
}

}  // namespace patinate::simulation
