// Lamps that are not fully known, and photographs without a scan.
#include <gtest/gtest.h>

#include <cmath>

#include "capture/unlighting/photometric_normals.h"
#include "patinate/capture/unlight.h"
#include "patinate/core/error.h"
#include "tests/capture/unlighting/lit_relief.h"

namespace patinate::capture {
namespace {

using namespace testing_support;

/// Makes the given intensities a guess: each is off by a factor whose geometric mean is 1. @returns the factors that
/// lead back.
std::vector<Vec3> spoil_intensities(UnlightInput& input) {
  std::vector<Vec3> truth;
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < input.lights.size(); ++k) {
    const auto i = static_cast<double>(k);
    const Vec3 log_factor(0.4 * std::sin(3.0 * i), 0.3 * std::cos(2.0 * i), 0.35 * std::sin(5.0 * i + 1.0));
    truth.push_back(log_factor);
    sum += log_factor;
  }
  for (std::size_t k = 0; k < truth.size(); ++k) {
    truth[k] = (truth[k] - sum / static_cast<double>(truth.size())).array().exp().matrix();
    input.lights[k].intensity = input.lights[k].intensity.cwiseQuotient(truth[k]);
  }
  return truth;
}

double worst_strength_error(const UnlightResult& result, const std::vector<Vec3>& truth, int channels) {
  double worst = 0.0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    for (int c = 0; c < channels; ++c)
      worst = std::max(worst, std::abs(result.lights[k].strength[c] / truth[k][c] - 1.0));
  }
  return worst;
}

/// Steps stop at 1e-6; photographs are float.
constexpr double kSettled = 1e-4;

TEST(LampEstimate, StrengthsOfAnExactSceneAreRecovered) {
  LitRelief scene = lit_relief({.size = 64, .cast_shadows = false});
  const std::vector<Vec3> truth = spoil_intensities(scene.input);
  const UnlightResult result = unlight(scene.input, {.specular = SpecularMode::None, .estimate_strengths = true});
  EXPECT_TRUE(result.is_converged);
  EXPECT_LT(worst_strength_error(result, truth, 3), kSettled);
  EXPECT_LT(relative_error_percent(result, scene.albedo), 0.02);
}

TEST(LampEstimate, AmbientOfAnExactSceneIsRecovered) {
  const LitRelief scene = lit_relief({.size = 64, .cast_shadows = false, .ambient = Vec3(0.2, 0.1, 0.05)});
  const UnlightResult unaware = unlight(scene.input, {.specular = SpecularMode::None});
  const UnlightResult result = unlight(scene.input, {.specular = SpecularMode::None, .estimate_ambient = true});
  EXPECT_GT(relative_error_percent(unaware, scene.albedo), 3.0);
  EXPECT_TRUE(result.is_converged);
  EXPECT_LT((result.ambient - Vec3(0.2, 0.1, 0.05)).cwiseAbs().maxCoeff(), kSettled);
  EXPECT_LT(relative_error_percent(result, scene.albedo), 0.02);
}

TEST(LampEstimate, BothAreFoundOnTheNoisyRig) {
  LitRelief scene = lit_relief({.normal_noise_deg = 1.8, .noise_share = 0.005, .ambient = Vec3(0.1, 0.1, 0.1)});
  scene.input.blockers = &scene.scan;
  const std::vector<Vec3> truth = spoil_intensities(scene.input);
  const UnlightResult result = unlight(scene.input, {.estimate_strengths = true, .estimate_ambient = true});
  EXPECT_TRUE(result.is_converged);
  EXPECT_LT(worst_strength_error(result, truth, 3), 0.01);
  EXPECT_LT(relative_error_percent(result, scene.albedo), 1.1);
}

TEST(LampEstimate, APlaneUnderDistantLampsDoesNotTellThem) {
  LitRelief scene =
      lit_relief({.size = 32, .height_mm = 0.0, .num_lights = 5, .kind = Light::Kind::Directional, .is_gray = true});
  scene.input.normal = ImageF();
  const UnlightResult result = unlight(scene.input, {.specular = SpecularMode::None, .estimate_strengths = true});
  EXPECT_FALSE(result.is_converged);
  ASSERT_FALSE(result.notes.empty());
}

TEST(PhotometricStereo, NormalsAndAlbedoOfAnExactSceneAreRecovered) {
  LitRelief scene = lit_relief({.size = 64, .kind = Light::Kind::Directional, .cast_shadows = false});
  scene.input.normal = scene.input.position_mm = ImageF();
  scene.input.camera_center.reset();
  const UnlightResult result = unlight(scene.input);
  EXPECT_GT(result.num_determined, result.num_surface * 99 / 100);
  EXPECT_LT(relative_error_percent(result, scene.albedo), 0.01);
  EXPECT_LT(median_angle_deg(result.normal, scene.normal, result.mask), 0.01);
}

TEST(PhotometricStereo, ShadowsDoNotBendTheNormals) {
  LitRelief scene = lit_relief({.num_lights = 12, .kind = Light::Kind::Directional, .noise_share = 0.005});
  const ImageF start = photometric_normals(scene.input.photos, {}, {}, scene.input.lights);
  EXPECT_LT(median_angle_deg(start, scene.normal, {}), 0.6);
  scene.input.normal = scene.input.position_mm = ImageF();
  scene.input.camera_center.reset();
  const UnlightResult result = unlight(scene.input, {.specular = SpecularMode::None});
  const UnlightResult plain = unlight(scene.input, {.rejection = Rejection::None, .specular = SpecularMode::None});
  EXPECT_LT(median_angle_deg(result.normal, scene.normal, result.mask), 0.2);
  EXPECT_LT(relative_error_percent(result, scene.albedo), 2.0);
  EXPECT_GT(relative_error_percent(plain, scene.albedo), 2.0 * relative_error_percent(result, scene.albedo));
}

TEST(PhotometricStereo, UnknownStrengthsAreRecoveredAlong) {
  LitRelief scene = lit_relief(
      {.size = 64, .num_lights = 10, .kind = Light::Kind::Directional, .cast_shadows = false, .is_gray = true});
  scene.input.normal = scene.input.position_mm = ImageF();
  scene.input.camera_center.reset();
  for (std::size_t k = 0; k < scene.input.lights.size(); ++k)
    scene.input.lights[k].intensity = Vec3::Constant(scene.input.lights[k].intensity.mean());
  const double factor = 1.25;
  scene.input.lights[3].intensity *= factor;
  const UnlightResult result = unlight(scene.input, {.specular = SpecularMode::None, .estimate_strengths = true});
  EXPECT_TRUE(result.is_converged);
  EXPECT_NEAR(result.lights[3].strength[0] / result.lights[4].strength[0], 1.0 / factor, 1e-3);
  EXPECT_LT(median_angle_deg(result.normal, scene.normal, result.mask), 0.05);
}

TEST(PhotometricStereo, SaysWhatItNeeds) {
  LitRelief scene = lit_relief({.size = 16, .num_lights = 4, .cast_shadows = false});
  scene.input.normal = ImageF();
  EXPECT_THROW((void)unlight(scene.input), InvalidInput);  // Near lamps.
  scene = lit_relief({.size = 16, .num_lights = 4, .kind = Light::Kind::Directional, .cast_shadows = false});
  scene.input.normal = ImageF();
  EXPECT_THROW((void)unlight(scene.input, {.normals = NormalMode::Keep}), InvalidInput);
  for (Light& light : scene.input.lights)
    light.direction = Vec3(light.direction.x(), 0, light.direction.z()).normalized();
  EXPECT_THROW((void)unlight(scene.input), InvalidInput);  // In a plane.
}

}  // namespace
}  // namespace patinate::capture
