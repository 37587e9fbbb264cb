#include "simulation/transport/splat.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "simulation/transport/exchange.h"
#include "tests/simulation/transport/transport_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::seamed_plane;
using testing_support::squeezed_plane;
using testing_support::TransportScene;

constexpr std::uint64_t kSeed = 11;

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
  Exchanger exchanger(1, kSeed);
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
