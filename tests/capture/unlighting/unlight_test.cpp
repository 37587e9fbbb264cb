#include "patinate/capture/unlight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "patinate/core/error.h"
#include "tests/capture/unlighting/lit_relief.h"
#include "tests/support/errors.h"

namespace patinate::capture {
namespace {

using namespace testing_support;

/// Photographs are float: a few units in the last place.
constexpr double kRoundingPercent = 2e-4;

std::string unlight_error(const UnlightInput& input, const UnlightOptions& options = {}) {
  try {
    (void)unlight(input, options);
  } catch (const InvalidInput& e) {
    return e.what();
  }
  return "";
}
TEST(Unlight, AlbedoOfALambertianSceneIsExactToRounding) {
  for (const Light::Kind kind : {Light::Kind::Near, Light::Kind::Directional}) {
    const LitRelief scene = lit_relief({.size = 48, .kind = kind, .cast_shadows = false});
    for (const Rejection rejection : {Rejection::None, Rejection::Robust}) {
      for (const NormalMode normals : {NormalMode::Keep, NormalMode::Refine}) {
        const UnlightResult result = unlight(scene.input, {.normals = normals, .rejection = rejection});
        EXPECT_EQ(result.num_determined, result.num_surface);
        EXPECT_LT(relative_error_percent(result, scene.albedo), kRoundingPercent);
        EXPECT_LT(result.residual, 1e-5);
      }
    }
  }
}

TEST(Unlight, ADisturbedNormalIsFoundAgainFromExactPhotographs) {
  const LitRelief scene = lit_relief({.size = 64, .cast_shadows = false, .normal_noise_deg = 1.8});
  const UnlightResult kept = unlight(scene.input, {.normals = NormalMode::Keep});
  const UnlightResult refined = unlight(scene.input);
  EXPECT_GT(relative_error_percent(kept, scene.albedo), 0.5);
  EXPECT_LT(relative_error_percent(refined, scene.albedo), 0.01);
  EXPECT_LT(median_angle_deg(refined.normal, scene.normal, refined.mask), 0.01);
}

TEST(Unlight, PhotographsWithoutNoiseAreNotRejectedWhereTheScanIsALittleOff) {
  // Most normals exact, so that the noise that is found is rounding's; the others 1.8 degrees off, which are some 3 %
  // in grazing light.
  LitRelief scene = lit_relief({.size = 64, .cast_shadows = false, .normal_noise_deg = 1.8});
  constexpr int kExact = 40;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < kExact; ++x) {
      for (int c = 0; c < 3; ++c) scene.input.normal.at(x, y, c) = scene.normal.at(x, y, c);
    }
  }
  const UnlightResult result = unlight(scene.input, {.normals = NormalMode::Keep, .specular = SpecularMode::None});
  EXPECT_LT(result.noise_scale, 0.01);
  EXPECT_GT(result.num_determined, result.num_surface * 95 / 100);
  EXPECT_LT(relative_error_percent(result, scene.albedo), 1.0);
}

TEST(Unlight, CastShadowsAreLeftOutByRaysAndByResidual) {
  LitRelief scene = lit_relief();
  scene.input.blockers = &scene.scan;
  const UnlightResult by_rays = unlight(scene.input);
  scene.input.blockers = nullptr;
  const UnlightResult by_residual = unlight(scene.input);
  const UnlightResult plain = unlight(scene.input, {.normals = NormalMode::Keep, .rejection = Rejection::None});
  std::int64_t num_shadowed = 0;
  for (std::uint8_t v : scene.shadow.values()) num_shadowed += v != 0;
  EXPECT_GT(num_shadowed, 500);
  EXPECT_GT(relative_error_percent(plain, scene.albedo), 3.0);
  // The scan's triangles move the shadows' borders, where some texels are left with few lamps.
  EXPECT_LT(relative_error_percent(by_rays, scene.albedo), 0.2);
  EXPECT_LT(relative_error_percent(by_residual, scene.albedo), 0.5);
  EXPECT_GT(by_rays.num_determined, by_rays.num_surface * 99 / 100);
}

TEST(Unlight, TheSameBitsForAnyNumberOfThreads) {
  LitRelief scene = lit_relief({.size = 48, .normal_noise_deg = 1.8, .noise_share = 0.005, .coding = Coding::Srgb8});
  scene.input.blockers = &scene.scan;
  RunControl one, three;
  one.num_threads = 1, three.num_threads = 3;
  const UnlightResult a = unlight(scene.input, {}, one), b = unlight(scene.input, {}, three);
  EXPECT_EQ(a.albedo, b.albedo);
  EXPECT_EQ(a.stddev, b.stddev);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.residual, b.residual);
}

TEST(Unlight, StandardDeviationsAreThoseOfTheErrors) {
  const LitRelief scene = lit_relief({.cast_shadows = false, .normal_noise_deg = 1.8, .noise_share = 0.01});
  const UnlightResult result = unlight(scene.input, {.normal_sigma_deg = 1.8});
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < result.albedo.values().size(); ++i) {
    const double z =
        static_cast<double>((result.albedo.values()[i] - scene.albedo.values()[i]) / result.stddev.values()[i]);
    sum += z * z;
    count += 1.0;
  }
  // Unit variance, were the noise model exact; residuals of few degrees of freedom widen some.
  EXPECT_NEAR(std::sqrt(sum / count), 1.0, 0.15);
}

TEST(Unlight, SaysWhatIsWrongWithItsInput) {
  const LitRelief scene = lit_relief({.size = 24, .num_lights = 4, .cast_shadows = false});
  UnlightInput input = scene.input;
  input.photos[2] = ImageF(23, 24, 3, 0.5f);
  EXPECT_TRUE(has(unlight_error(input), "photograph 3 is 23 x 24"));
  input = scene.input;
  input.photos.pop_back();
  EXPECT_TRUE(has(unlight_error(input), "3 photographs and 4 lights"));
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    input = scene.input;
    input.lights[1].intensity.y() = bad;
    EXPECT_TRUE(has(unlight_error(input), "light 2 has the intensity"));
  }
  input = scene.input;
  for (Light& light : input.lights) light.position.z() = -500.0;
  EXPECT_TRUE(has(unlight_error(input), "no light reaches the surface"));
  input = scene.input;
  input.photos[3] = ImageF(24, 24, 3, 0.0f);
  EXPECT_TRUE(has(unlight_error(input), "photograph 4 is black"));
  input = scene.input;
  input.valid.assign(4, ImageU8(24, 24));
  EXPECT_TRUE(has(unlight_error(input), "saturated (white)"));
  input = scene.input;
  input.normal.at(3, 4, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(has(unlight_error(input), "the normal at pixel (3, 4) is not finite"));
  input = scene.input;
  input.photos[0].at(5, 6, 2) = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(has(unlight_error(input), "photograph 1 at pixel (5, 6)"));
  input = scene.input;
  input.position_mm = ImageF();
  EXPECT_TRUE(has(unlight_error(input), "near lights need"));
  input = scene.input;
  input.mask = ImageU8(24, 24);
  EXPECT_TRUE(has(unlight_error(input), "no surface"));
  EXPECT_TRUE(has(unlight_error(scene.input, {.rejection_sigma = 0.0}), "rejection_sigma"));
}

TEST(Unlight, ALampBehindTheObjectIsNamedAndDoesNoHarm) {
  LitRelief scene = lit_relief({.size = 32, .cast_shadows = false});
  scene.input.lights[5].position.z() *= -1.0;
  const UnlightResult result = unlight(scene.input);
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_TRUE(has(result.notes[0], "light 6 lights nothing that the camera sees"));
  EXPECT_LT(relative_error_percent(result, scene.albedo), kRoundingPercent);
}

TEST(Unlight, TexelsWithoutACleanLampAreFlaggedAndNotGuessed) {
  LitRelief scene = lit_relief({.size = 32, .num_lights = 4, .cast_shadows = false});
  scene.input.valid.assign(4, ImageU8(32, 32, 1, 255));
  for (int k = 0; k < 4; ++k) scene.input.valid[k].at(7, 9) = 0;
  for (int k = 0; k < 3; ++k) scene.input.valid[k].at(8, 9) = 0;
  const UnlightResult result = unlight(scene.input);
  EXPECT_EQ(result.mask.at(7, 9), 0);
  EXPECT_EQ(result.albedo.at(7, 9, 1), 0.0f);
  EXPECT_EQ(result.mask.at(8, 9), 0);
  EXPECT_EQ(result.num_determined, result.num_surface - 2);
  EXPECT_EQ(unlight(scene.input, {.min_lights = 1}).mask.at(8, 9), 255);
}

}  // namespace
}  // namespace patinate::capture
