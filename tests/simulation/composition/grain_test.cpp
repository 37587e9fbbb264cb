#include "simulation/composition/grain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "patinate/image/color.h"
#include "tests/simulation/composition/compose_scene.h"
#include "tests/support/meshes.h"
#include "tests/support/reference_compose.h"

namespace patinate::simulation {
namespace {

using testing_support::compare_coarse_with_fine;
using testing_support::ComposeScene;

MaterialAppearance grainy(double grain_mm, double variation = 0.8) {
  MaterialAppearance look;
  look.color.color = {0.5, 0.1, 0.05};
  look.second_color = Vec3(0.1, 0.05, 0.02);
  look.variation = variation;
  look.specular = 0.4;
  look.specular_variation = 0.5;
  look.grain_mm = grain_mm;
  return look;
}

/// A plate of `side` mm under an even layer of half an amount.
ComposeScene plate(double side, int resolution, double grain_mm, double variation = 0.8) {
  ComposeScene scene(testing_support::unit_plane(side), resolution, {grainy(grain_mm, variation)});
  scene.set(0, [](int, int, const Vec3&) { return 0.5; });
  return scene;
}

TEST(Grain, FastAndSlowVersionsAgreeToACode) {
  const ComposeScene scene = plate(100.0, 96, 20.0);
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const std::vector<ReferenceTexel> slow =
      compose_reference(scene.scene, scene.scene_mesh, *scene.atlas, ColorForm::Normalized);
  for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
    if (!scene.surface->is_covered(t)) continue;
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(composer.codes()[t] >> (8 * c) & 255, srgb8_from_linear(static_cast<float>(slow[t].color[c])), 1);
    ASSERT_NEAR(composer.codes()[t] >> 24, std::round(255.0 * slow[t].specular), 1);
  }
}

/// Mean of the squared differences of green between texels so many steps apart, over twice the variance: 0 = equal, 1 =
/// unrelated.
double unlikeness(const ImageF& color, int steps) {
  double mean = 0.0, squares = 0.0, differences = 0.0, n = 0.0;
  for (int y = 8; y < color.height() - 8; ++y) {
    for (int x = 8; x < color.width() - 8 - steps; ++x) {
      const auto a = static_cast<double>(color.at(x, y, 1)), b = static_cast<double>(color.at(x + steps, y, 1));
      mean += a, squares += a * a, differences += (a - b) * (a - b), n += 1.0;
    }
  }
  return differences / n / (2.0 * (squares / n - mean / n * mean / n));
}

TEST(Grain, VariesOverItsLengthAndNotFromTexelToTexel) {
  const ImageF color = plate(128.0, 128, 32.0).composed(), white = plate(128.0, 128, 0.0).composed();
  // Without it each texel is by itself; with it half of the variance lies at 8 mm and more.
  EXPECT_GT(unlikeness(white, 1), 0.9);
  EXPECT_LT(unlikeness(color, 1), 0.4);
  EXPECT_GT(unlikeness(color, 32), 0.7);
}

TEST(Grain, AFinerAtlasShowsTheSameOneSharper) {
  // Weights that vary with the colors would make a mean of products.
  const auto [mean_square, variance] =
      compare_coarse_with_fine(plate(128.0, 64, 64.0, 0.0).composed(), plate(128.0, 256, 64.0, 0.0).composed());
  // What the coarse one leaves out, the octave of two of its texels, has 0.3 of the spread, and half of it survives the
  // mean over a texel; of the octave of four texels, 0.6 of the spread, the mean takes a fifth: 0.15 + 0.12.
  EXPECT_LT(std::sqrt(mean_square), 0.3 * std::sqrt(variance));
}

TEST(Grain, IsNotSeenOverASeam) {
  ComposeScene cut(testing_support::cut_plane(100.0), 128, {grainy(25.0)});
  cut.set(0, [](int, int, const Vec3&) { return 0.5; });
  Composer composer = cut.composer();
  (void)composer.compose(*cut.atlas, {});
  double inside = 0.0, across = 0.0, num_inside = 0.0, num_across = 0.0;
  const auto red = [&](TexelIndex t) { return static_cast<double>(composer.codes()[t] & 255); };
  for (TexelIndex t = 0; t < cut.surface->grid().num_texels(); ++t) {
    if (!cut.surface->is_covered(t)) continue;
    const auto& border = cut.surface->border();
    const bool is_border = std::binary_search(border.begin(), border.end(), t);
    for (const TexelIndex n : cut.surface->neighbors(t)) {
      if (n == kNoTexel) continue;
      (is_border ? across : inside) += std::abs(red(t) - red(n));
      (is_border ? num_across : num_inside) += 1.0;
    }
  }
  ASSERT_GT(num_across, 100.0);
  // Texels over a seam lie up to one and a half of them apart.
  EXPECT_LT(across / num_across, 1.5 * inside / num_inside);
}

TEST(Grain, OfOneMaterialIsNotThatOfAnother) {
  ComposeScene scene(testing_support::unit_plane(100.0), 64, {grainy(20.0), grainy(20.0)});
  const composition::TexelPlaces places(scene.scene_mesh, *scene.surface);
  composition::Grain grain(places);
  grain.set_lengths({20.0, 20.0});
  double a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0, n = 0.0;
  for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
    if (!scene.surface->is_covered(t)) continue;
    const double x = grain.value(0, t), y = grain.value(1, t);
    a += x, b += y, aa += x * x, bb += y * y, ab += x * y, n += 1.0;
  }
  const double correlation = (ab / n - a / n * b / n) / std::sqrt((aa / n - a / n * a / n) * (bb / n - b / n * b / n));
  // Some 25 patches of the coarse octave: a standard error of a fifth, three of them.
  EXPECT_LT(std::abs(correlation), 0.6);
}

}  // namespace
}  // namespace patinate::simulation
