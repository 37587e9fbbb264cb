#include "capture/unlighting/specular_choice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/capture/unlighting/lit_relief.h"

namespace patinate::capture {
namespace {

using namespace testing_support;

/// A gray texel of albedo 0.5 under three lamps that shine straight down; values that fit but for what a test adds.
TexelSamples three_lamps() {
  TexelSamples s;
  s.resize(3, 1);
  for (std::size_t k = 0; k < 3; ++k) {
    s.direction[k] = Vec3(0, 0, 1);
    s.irradiance[k] = 1.0;
    s.value[k] = 0.5;
    s.variance[k] = 0.01 * 0.01;
    s.state[k] = SampleState::Clean;
  }
  return s;
}

TEST(RobustCost, IsChiSquareThatNoLampRaisesAboveItsRejection) {
  TexelSamples s = three_lamps();
  const TexelFit fit{.is_determined = true, .albedo = {0.5, 0.0, 0.0}};
  const TexelFitOptions options{.rejection_sigma = 3.0};
  const std::vector<double> plain = s.variance;
  EXPECT_EQ(robust_cost(s, plain, fit, options), 0.0);
  s.value[0] = 0.52;  // Two standard deviations.
  EXPECT_NEAR(robust_cost(s, plain, fit, options), 4.0, 1e-9);
  s.value[1] = 0.9;
  EXPECT_NEAR(robust_cost(s, plain, fit, options), 4.0 + 9.0, 1e-9);
  s.variance[2] *= 4.0;  // Less certain, though it fits: the logarithm of a Gaussian's width.
  EXPECT_NEAR(robust_cost(s, plain, fit, options), 4.0 + 9.0 + std::log(4.0), 1e-9);
  s.state[1] = SampleState::CastShadow;
  EXPECT_NEAR(robust_cost(s, plain, fit, options), 4.0 + std::log(4.0), 1e-9);
}

/// A diffuse relief of which blocks of `block` pixels are glossy, one of `every`.
LitRelief patches_of_gloss(int block, int every, LitReliefOptions o) {
  LitRelief scene = lit_relief(o);
  o.gloss = 0.1;
  const LitRelief glossy = lit_relief(o);
  for (std::size_t k = 0; k < scene.input.photos.size(); ++k) {
    const double exposure =
        scene.input.lights[k].intensity.x() / glossy.input.lights[k].intensity.x();  // Each was exposed for itself.
    for (int y = 0; y < o.size; ++y) {
      for (int x = 0; x < o.size; ++x) {
        if ((x / block + 2 * (y / block)) % every != 0) continue;
        for (int c = 0; c < 3; ++c)
          scene.input.photos[k].at(x, y, c) =
              static_cast<float>(exposure * static_cast<double>(glossy.input.photos[k].at(x, y, c)));
      }
    }
  }
  return scene;
}

double error_percent(const LitRelief& scene, SpecularMode mode) {
  return relative_error_percent(unlight(scene.input, {.specular = mode}), scene.albedo);
}

TEST(SharedHighlights, PatchesOfGlossAreFoundAmongMattMaterial) {
  const LitRelief scene =
      patches_of_gloss(24, 5, {.cast_shadows = false, .normal_noise_deg = 1.8, .noise_share = 0.017});
  const double none = error_percent(scene, SpecularMode::None), fit = error_percent(scene, SpecularMode::Fit),
               chosen = error_percent(scene, SpecularMode::Auto);
  EXPECT_LT(fit, 0.75 * none);
  EXPECT_LT(chosen, 1.1 * fit);
}

TEST(SharedHighlights, NarrowOnesOfAFewTexelsAreRejectedNotSubtracted) {
  struct Scene {
    int block;
    double exponent,
        harm;  ///< Exponent and harm of a lobe that is pulled over everything, over none: scenes where it matters.
  };
  for (const Scene& s : {Scene{4, 400.0, 1.0}, Scene{6, 1000.0, 1.2}}) {
    const LitRelief scene = patches_of_gloss(
        s.block, 5,
        {.cast_shadows = false, .gloss_exponent = s.exponent, .normal_noise_deg = 1.8, .noise_share = 0.017});
    const double none = error_percent(scene, SpecularMode::None), fit = error_percent(scene, SpecularMode::Fit),
                 chosen = error_percent(scene, SpecularMode::Auto);
    EXPECT_GT(fit, s.harm * none) << s.block;
    EXPECT_LT(chosen, 1.02 * none) << s.block;
  }
}

TEST(SharedHighlights, ALobeOfAllTexelsStaysAsItWasFitted) {
  const LitRelief scene = lit_relief(
      {.cast_shadows = false, .gloss = 0.05, .lobe = Gloss::Ggx, .normal_noise_deg = 1.8, .noise_share = 0.005});
  const UnlightResult fit = unlight(scene.input, {.specular = SpecularMode::Fit});
  const UnlightResult chosen = unlight(scene.input);
  EXPECT_EQ(chosen.specular, fit.specular);
}

}  // namespace
}  // namespace patinate::capture
