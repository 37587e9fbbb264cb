#include "simulation/transport/splat.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "simulation/transport/exchange.h"
#include "simulation/transport/surface_walk.h"
#include "tests/simulation/transport/transport_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::seamed_plane;
using testing_support::squeezed_plane;
using testing_support::TransportScene;

constexpr std::uint64_t kSplatSeed = 11;

/// Texels that a walk may come to: those nearest by links, as far as there is room for them.
std::set<TexelIndex> reachable(const SurfaceAtlas& surface, TexelIndex middle, int depth) {
  std::vector<TexelIndex> order{middle};
  std::set<TexelIndex> all{middle};
  std::array<SurfaceAtlas::Link, 4> plain;
  for (std::size_t begin = 0; depth > 0; --depth) {
    const std::size_t end = order.size();
    for (; begin < end; ++begin) {
      for (const SurfaceAtlas::Link& link : surface.links(order[begin], plain)) {
        if (all.size() < SplatShape::kMaxParts && all.insert(link.texel).second) order.push_back(link.texel);
      }
    }
  }
  return all;
}

/// What is where after a walk from `middle`: step by step, each texel giving to those that it is linked with. The slow
/// version of walk_surface(), which leaves out what is below least_of() and rounds.
std::map<TexelIndex, double> slow_walk(const SurfaceAtlas& surface, TexelIndex middle, int size) {
  const WalkLength walk = walk_length(size);
  const int depth = static_cast<int>(std::ceil(std::sqrt(16.0 * size / kVarianceOne)));
  const std::set<TexelIndex> all = reachable(surface, middle, std::min(depth, walk.num_steps));
  std::map<TexelIndex, double> share{{middle, 1.0}};
  for (int step = 0; step < walk.num_steps; ++step) {
    std::map<TexelIndex, double> next = share;
    for (const auto& [from, there] : share) {
      std::array<SurfaceAtlas::Link, 4> plain;
      for (const SurfaceAtlas::Link& link : surface.links(from, plain)) {
        if (!all.contains(link.texel)) continue;
        const double weight = surface.weight(from), other = surface.weight(link.texel);
        const double whole = surface.weight_of_triangle(surface.triangle(from)) +
                             surface.weight_of_triangle(surface.triangle(link.texel));
        const double between = std::min(whole / 2.0, 2.0 * std::min(weight, other));
        const double goes = there * walk.share * link.count / 2.0 * between / weight;
        next[link.texel] += goes;
        next[from] -= goes;
      }
    }
    share = next;
  }
  return share;
}

/// The parts of a splat, middle first.
std::vector<SplatPart> splat_of(const SurfaceAtlas& surface, TexelIndex texel, double width) {
  std::vector<SplatPart> parts;
  const std::size_t num_parts = SplatShape(surface, width).append(texel, parts);
  EXPECT_EQ(num_parts, parts.size());
  return parts;
}

TEST(Splat, SharesSumToTheWholeAndEvenRainStaysEvenAlsoAcrossASeam) {
  const TransportScene scene = seamed_plane(128);
  for (const double width : {1.0, 3.0, 5.0, 6.0, 12.0, SplatShape::kWidest}) {
    const SplatShape shape(*scene.surface, width);
    std::map<TexelIndex, double> received;
    std::size_t most = 0;
    for (const TexelIndex t : scene.covered) {
      std::vector<SplatPart> parts;
      most = std::max(most, shape.append(t, parts));
      std::uint32_t sum = 0;
      for (const SplatPart& part : parts) {
        EXPECT_TRUE(scene.surface->is_covered(part.texel));
        EXPECT_GT(part.share, 0u);
        sum += part.share;
        received[part.texel] += static_cast<double>(part.share) / SplatShape::kWhole * scene.surface->weight(t);
      }
      ASSERT_EQ(sum, SplatShape::kWhole);
      EXPECT_EQ(parts[0].texel, t);
      EXPECT_EQ(parts.size() > 1, width > 1.0);
    }
    EXPECT_LE(most, SplatShape::kMaxParts);
    // Every texel hit as often as it is large: each receives as much as it gives away, at seams and at the surface's
    // end as well. Left out of a splat is about 1/32, which the rest makes up for: what is missing where two
    // kinds of edges meet is a part of that.
    const double bound = width > 3.0 ? 1.0 / 32.0 : 0.01;
    for (const TexelIndex t : scene.covered) {
      EXPECT_NEAR(received[t] / scene.surface->weight(t), 1.0, bound)
          << width << " at " << scene.surface->grid().x(t) << ", " << scene.surface->grid().y(t);
    }
  }
}

TEST(Splat, IsWhatAStepByStepWalkLeavesAlsoAcrossASeam) {
  const TransportScene scene = seamed_plane(64);
  const SurfaceAtlas& surface = *scene.surface;
  for (const int size : {kVarianceOne / 5, 2 * kVarianceOne, 30 * kVarianceOne}) {  // of 1, 8 and 120 steps
    for (std::size_t k = 0; k < surface.border().size(); k += 37) {
      const TexelIndex middle = surface.border()[k];
      const std::map<TexelIndex, double> slow = slow_walk(surface, middle, size);
      const double least =
          transfer_kernel::least_of_walk(walk_length(size).num_steps) * slow.at(middle) / surface.weight(middle);
      double sum = 0.0;
      for (const auto& [t, share] : slow) sum += t == middle || share / surface.weight(t) >= least ? share : 0.0;
      std::vector<SplatPart> parts;
      walk_surface(surface, middle, size, parts);
      ASSERT_EQ(parts[0].texel, middle);
      std::map<TexelIndex, double> fast;
      for (std::size_t p = 1; p < parts.size(); ++p) fast[parts[p].texel] = parts[p].share;
      for (const auto& [t, share] : slow) {
        const double per_area = share / surface.weight(t), whole = share / sum * SplatShape::kWhole;
        // Shares as large as the least are left out or not, by the order of a sum.
        if (t == middle || std::abs(per_area - least) < 1e-9 * least) continue;
        EXPECT_NEAR(fast[t], per_area < least ? 0.0 : std::floor(whole), whole - std::floor(whole) < 1e-6 ? 1.0 : 0.0)
            << size << " from " << middle << " to " << t;
      }
    }
  }
}

TEST(Splat, IsOfOneSizeOnTheSurfaceNotInTexels) {
  const TransportScene scene = squeezed_plane(128);
  for (const TexelIndex t : scene.covered) {
    const double side = std::sqrt(double(scene.surface->weight(t)) / SurfaceAtlas::kMedianWeight);
    const std::vector<SplatPart> splat = splat_of(*scene.surface, t, 3);
    if (side > 2.1) {  // a texel wider than the splat
      EXPECT_EQ(splat.size(), 1u);
    }
    if (side > 0.7 && side < 1.9) {
      EXPECT_GE(splat.size(), 3u);  // a corner of the plane has two neighbors
    }
    if (side < 0.6) {
      EXPECT_GE(splat.size(), 6u);
    }
  }
}

TEST(Splat, HasItsWidthInMmAtEveryResolution) {
  constexpr double kWidth = 6.0;  // mm: 3.8 to 15 texels
  for (const int resolution : {64, 128, 256}) {
    const TransportScene scene = seamed_plane(resolution);  // 100 mm, a chart on the left, a turned one on the right
    const SurfaceAtlas& surface = *scene.surface;
    const double texel_mm = surface.median_texel_size_mm();
    const TileGrid& grid = surface.grid();
    std::vector<TexelIndex> inside;
    for (const TexelIndex t : scene.covered) {
      if (surface.is_plain(TileGrid::tile_of(t))) inside.push_back(t);
    }
    const TexelIndex middle = inside[inside.size() / 2];
    double variance[2] = {0, 0};
    for (const SplatPart& part : splat_of(surface, middle, kWidth / texel_mm)) {
      const double dx = (grid.x(part.texel) - grid.x(middle)) * texel_mm;
      const double dy = (grid.y(part.texel) - grid.y(middle)) * texel_mm;
      variance[0] += dx * dx * part.share / SplatShape::kWhole;
      variance[1] += dy * dy * part.share / SplatShape::kWhole;
    }
    for (const double v : variance) {
      // A Gaussian cut off where it is 1/32 of its height has 0.94 of its standard deviation.
      const double texels = kWidth / 6.0 / texel_mm;
      const double rounding = 0.25 / (64.0 * texels * texels);  // of the variance to 1/64 texel^2
      EXPECT_LT(std::sqrt(v), (1.0 + rounding) * kWidth / 6.0) << resolution;
      EXPECT_GT(std::sqrt(v), 0.93 * kWidth / 6.0) << resolution;
    }
  }
}

TEST(Splat, DealsOutLessThanAQuantumForEachPartWithoutBias) {
  // One quantum of cargo, dropped entirely: it arrives at one of the parts, as often as that part's share says.
  const TransportScene scene = seamed_plane(128);
  const TexelIndex middle = scene.surface->grid().index(40, 60);
  constexpr int kRuns = 20'000;
  Exchanger exchanger(1, kSplatSeed);
  for (int i = 0; i < kRuns; ++i) {
    Cargo cargo;
    cargo.mass.push_back({scene.surface->weight(middle)});
    const std::vector<Contact> contact{{middle, 0}};
    (void)exchanger.exchange(contact, {.ratio = 1.0, .rates = {1.0}, .contact = 1e3, .splat_texels = 5}, i, cargo,
                             *scene.atlas);
    EXPECT_EQ(cargo.mass[0][0], 0u);
  }
  for (const SplatPart& part : splat_of(*scene.surface, middle, 3.0 * std::numbers::sqrt2)) {
    const double p = static_cast<double>(part.share) / SplatShape::kWhole;
    EXPECT_NEAR(scene.atlas->amount(0, part.texel), kRuns * p, 4.0 * std::sqrt(kRuns * p * (1 - p)));
  }
}

}  // namespace
}  // namespace patinate::simulation
