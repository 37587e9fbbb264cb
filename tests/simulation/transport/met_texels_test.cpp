#include "simulation/transport/met_texels.h"

#include <gtest/gtest.h>

#include <random>

#include "simulation/transport/exchange.h"
#include "tests/simulation/transport/transport_scene.h"

namespace patinate::simulation {
namespace {

using testing_support::seamed_plane;
using testing_support::TransportScene;

constexpr int kSide = 128;

/// The slow version: every middle lays a splat down. @param least  Parts with less of the middle's share are left out.
std::vector<bool> laid_down(const TransportScene& scene, const MetTexels& met, double width_texels, double least) {
  std::vector<bool> reached(scene.surface->grid().num_texels(), false);
  const SplatShape shape(*scene.surface, width_texels);
  for (const TexelIndex t : scene.covered) {
    if (!met.has(t)) continue;
    std::vector<SplatPart> parts;
    shape.append(t, parts);
    for (const SplatPart& part : parts) {
      if (part.share >= least * parts[0].share) reached[part.texel] = true;
    }
  }
  return reached;
}

MetTexels with_random_contacts(const TransportScene& scene, int count) {
  MetTexels met(scene.surface->grid());
  std::mt19937 random(3);
  for (int i = 0; i < count; ++i) {
    const Contact contact{.texel = scene.covered[random() % scene.covered.size()], .gammaton = 0};
    met.add(std::span(&contact, 1));
  }
  return met;
}

TEST(MetTexels, AreReachedWhereASplatOfAMiddleLies) {
  const TransportScene scene = seamed_plane(kSide);
  const MetTexels met = with_random_contacts(scene, 60);
  const TileGrid& grid = scene.surface->grid();
  for (const double width_texels : {3.0, 8.0}) {
    ExchangeOptions options;
    options.splat_mm = width_texels * scene.surface->median_texel_size_mm();
    const ImageU8 reached = reached_texels(met, options, *scene.surface);
    // A splat's rim is where a Gaussian has fallen to a 30th; near seams, where a walk ends it, that may be a texel
    // away from where the other's is. Well within, both have a part of each other; beyond a wider one, neither.
    const std::vector<bool> sure = laid_down(scene, met, width_texels, 0.125),
                            all = laid_down(scene, met, 1.5 * width_texels, 0.0);
    int num_reached = 0;
    for (const TexelIndex t : scene.covered) {
      const bool is = reached.at(grid.x(t), grid.y(t)) != 0;
      EXPECT_TRUE(is || !sure[t]) << grid.x(t) << ", " << grid.y(t);
      EXPECT_TRUE(!is || all[t]) << grid.x(t) << ", " << grid.y(t);
      num_reached += is ? 1 : 0;
    }
    EXPECT_GT(num_reached, 60);
    EXPECT_LT(num_reached, static_cast<int>(scene.covered.size()));
  }
}

TEST(MetTexels, AreTheMiddlesAloneWhereDropsHaveNoWidth) {
  const TransportScene scene = seamed_plane(kSide);
  const MetTexels met = with_random_contacts(scene, 60);
  ExchangeOptions options;
  options.splat_mm = 0.0;
  options.splat_texels = 1;
  const ImageU8 reached = reached_texels(met, options, *scene.surface);
  const TileGrid& grid = scene.surface->grid();
  for (const TexelIndex t : scene.covered) EXPECT_EQ(reached.at(grid.x(t), grid.y(t)) != 0, met.has(t));
}

}  // namespace
}  // namespace patinate::simulation
