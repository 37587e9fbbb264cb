#include "simulation/composition/laid_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libcommon/core/random.h"
#include "patinate/image/color.h"
#include "tests/simulation/composition/compose_scene.h"
#include "tests/support/meshes.h"
#include "tests/support/reference_compose.h"

namespace patinate::simulation {
namespace {

using testing_support::compare_coarse_with_fine;
using testing_support::ComposeScene;

/// Black to the left, white to the right.
ImageF halves(int width) {
  ImageF image(width, width, 3);
  for (int y = 0; y < width; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = 2 * x < width ? 0.0F : 1.0F;
    }
  }
  return image;
}

/// Independent pixels of three channels, uniform in [0.25, 0.75).
ImageF white_noise(int width, std::uint64_t seed) {
  ImageF image(width, width, 3);
  RandomStream random(seed, 1);
  for (float& value : image.values()) value = 0.25F + 0.5F * static_cast<float>(random.uniform());
  return image;
}

MaterialAppearance pictured(ImageF image, double width_mm) {
  MaterialAppearance look;
  look.color.image = std::move(image);
  look.color.image_mm = width_mm;
  return look;
}

/// Fully covered by a material with a picture.
ComposeScene covered(Mesh mesh, int resolution, const ImageF& image, double width_mm) {
  ComposeScene scene(std::move(mesh), resolution, {pictured(image, width_mm)});
  scene.set(0, [](int, int, const Vec3&) { return 1.0; });
  return scene;
}

TEST(LaidPicture, HasItsWidthInMm) {
  for (const int resolution : {64, 160}) {
    const ImageF color = covered(testing_support::unit_plane(120.0), resolution, halves(32), 40.0).composed();
    const int y = resolution / 2;
    int num_changes = 0;
    for (int x = 1; x < resolution; ++x)
      num_changes += (color.at(x, y, 1) > 0.5F) != (color.at(x - 1, y, 1) > 0.5F) ? 1 : 0;
    // Three pictures with two edges each; one of the six may coincide with the plate's end.
    EXPECT_GE(num_changes, 5) << resolution;
    EXPECT_LE(num_changes, 6) << resolution;
  }
}

TEST(LaidPicture, AFinerAtlasShowsTheSameOneSharper) {
  const ImageF picture = white_noise(64, 3);  // of pixels of 1 mm
  const auto [mean_square, variance] =
      compare_coarse_with_fine(covered(testing_support::unit_plane(128.0), 64, picture, 64.0).composed(),
                               covered(testing_support::unit_plane(128.0), 256, picture, 64.0).composed());
  // A texel of 2 mm averages four pixels, and both atlases interpolate between pixels half a texel off at most: of
  // white noise the two share at least half of their variance.
  EXPECT_LT(mean_square, variance);
  // Four independent values of variance 1/48.
  EXPECT_LT(variance, 1.3 / 48.0 / 4.0);
}

TEST(LaidPicture, KeepsItsContrastWhereSidesMeet) {
  const composition::LaidPicture picture({.image = white_noise(64, 5), .image_mm = 64.0}, 1.0);
  const double r2 = std::sqrt(0.5), r3 = std::sqrt(1.0 / 3.0);
  for (const Vec3& normal : {Vec3(0, 0, 1), Vec3(r2, r2, 0), Vec3(r2, 0, -r2), Vec3(r3, -r3, r3), Vec3(0, 0, 0)}) {
    double sum = 0.0, squares = 0.0;
    RandomStream random(7, 7);
    constexpr int kSamples = 20000;
    for (int i = 0; i < kSamples; ++i) {
      // At centers of pixels on all three sides, where nothing is interpolated.
      const Vec3 p(std::floor(64.0 * random.uniform()) + 0.5, std::floor(64.0 * random.uniform()) + 0.5,
                   std::floor(64.0 * random.uniform()) + 0.5);
      const double value = picture.color(p, normal)[0];
      sum += value, squares += value * value;
    }
    const double mean = sum / kSamples, variance = squares / kSamples - mean * mean;
    // 4096 pixels of variance 1/48, whose own variance is 1/48 (1 +- 0.9 sqrt(4 / 4096)), four deviations; sums of two
    // and three uniform ones stay within [0, 1].
    EXPECT_NEAR(variance, 1.0 / 48.0, 0.06 / 48.0) << normal.transpose();
    EXPECT_NEAR(mean, 0.5, 4.0 * std::sqrt(1.0 / 48.0 / 4096.0) + 4.0 * std::sqrt(1.0 / 48.0 / kSamples));
  }
}

TEST(LaidPicture, FastAndSlowVersionsAgreeToACode) {
  ComposeScene scene(testing_support::cut_plane(100.0), 64, {pictured(white_noise(32, 9), 25.0)},
                     [](Scene& s) { s.objects[0].preset.color = {.image = halves(16), .image_mm = 30.0}; });
  scene.set(0, [](int x, int, const Vec3&) { return x % 3 == 0 ? 0.4 : 1.2; });
  Composer composer = scene.composer();
  (void)composer.compose(*scene.atlas, {});
  const std::vector<ReferenceTexel> slow =
      compose_reference(scene.scene, scene.scene_mesh, *scene.atlas, ColorForm::Normalized);
  for (TexelIndex t = 0; t < scene.surface->grid().num_texels(); ++t) {
    if (!scene.surface->is_covered(t)) continue;
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(composer.codes()[t] >> (8 * c) & 255, srgb8_from_linear(static_cast<float>(slow[t].color[c])), 1);
  }
}

TEST(LaidPicture, GoesOnOverASeam) {
  ComposeScene cut = covered(testing_support::cut_plane(100.0), 128, halves(20), 20.0);
  Composer composer = cut.composer();
  (void)composer.compose(*cut.atlas, {});
  const composition::TexelPlaces places(cut.scene_mesh, *cut.surface);
  for (TexelIndex t = 0; t < cut.surface->grid().num_texels(); ++t) {
    if (!cut.surface->is_covered(t)) continue;
    const double x = places.point(t).x();
    if (const double to_edge = std::abs(x / 10.0 - std::round(x / 10.0)); to_edge < 0.2) continue;
    ASSERT_EQ((composer.codes()[t] & 255) > 127, x - 20.0 * std::floor(x / 20.0) > 10.0) << x;
  }
}

}  // namespace
}  // namespace patinate::simulation
