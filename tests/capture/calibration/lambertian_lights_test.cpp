#include "patinate/capture/lambertian_lights.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/support/errors.h"

namespace patinate::capture {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr double kPi = std::numbers::pi;

/// 500 mm above the table, looking down.
Camera camera_above() {
  CameraParameters p;
  p.width = 1600, p.height = 1200;
  p.fx = p.fy = 1800, p.cx = 799.5, p.cy = 599.5;
  p.rotation = Eigen::AngleAxisd(kPi, Vec3::UnitX()).toRotationMatrix();
  p.translation = {0, 0, 500};
  return Camera(p);
}

const std::vector<Vec3> kPositions{
    {200, 60, 330}, {-180, 150, 300}, {40, -220, 350}, {-120, -140, 380}, {150, 180, 280}};
const Vec3 kIntensity(1.0e5, 1.2e5, 0.9e5);

struct Scene {
  double ambient = 0.0;
  Vec2 vignetting = Vec2::Zero();
  double noise = 0.0;
};

/// Grids of 20 x 20 points on squares of 160 mm, tilted up to 25 degrees to all sides at different heights.
std::vector<ShadedSample> planes(const Camera& camera, const Vec3& light, int num_poses, const Scene& scene,
                                 std::uint64_t seed) {
  std::vector<ShadedSample> samples;
  RandomStream random(seed, 0, 0);
  const CameraParameters& c = camera.parameters();
  for (int pose = 0; pose < num_poses; ++pose) {
    const double side = 2.0 * pose, tilt = pose == 0 ? 0.0 : 0.15 + 0.03 * pose;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(tilt, Vec3(std::cos(side), std::sin(side), 0)).toRotationMatrix();
    for (int i = 0; i < 400; ++i) {
      ShadedSample s;
      s.point_mm = turn * Vec3(8.0 * (i % 20) - 76, 8.0 * (i / 20) - 76, 0) + Vec3(0, 0, 6.0 * pose);
      s.normal = turn.col(2);
      s.pixel = *camera.project(s.point_mm);
      const Vec3 to_light = light - s.point_mm;
      const double r2 = (s.pixel - Vec2(0.5 * (c.width - 1), 0.5 * (c.height - 1))).squaredNorm() /
                        Vec2(0.5 * c.width, 0.5 * c.height).squaredNorm();
      const double lens = 1.0 + scene.vignetting[0] * r2 + scene.vignetting[1] * r2 * r2;
      s.value =
          0.8 / kPi * kIntensity * std::max(0.0, to_light.normalized().dot(s.normal)) / to_light.squaredNorm() * lens +
          Vec3::Constant(scene.ambient);
      for (int k = 0; k < 3; ++k) s.value[k] += scene.noise * random.normal();
      samples.push_back(s);
    }
  }
  return samples;
}

LambertianLightResult solve(int num_poses, const Scene& scene, const LambertianLightOptions& options,
                            std::uint64_t seed = 1) {
  std::vector<std::vector<ShadedSample>> samples;
  for (std::size_t k = 0; k < kPositions.size(); ++k)
    samples.push_back(planes(camera_above(), kPositions[k], num_poses, scene, 10 * seed + k));
  return lights_from_lambertian(camera_above(), samples, options);
}

double worst_mm(const LambertianLightResult& result) {
  double worst = 0.0;
  for (std::size_t k = 0; k < kPositions.size(); ++k)
    worst = std::max(worst, (result.lights[k].light.position - kPositions[k]).norm());
  return worst;
}

TEST(LambertianLights, AreExactWithoutNoise) {
  const LambertianLightResult result = solve(3, {}, {.albedo = 0.8});
  constexpr double kRoundingMm = 1e-6;
  EXPECT_LT(worst_mm(result), kRoundingMm);
  for (const LambertianLight& light : result.lights) {
    EXPECT_EQ(light.status, CalibrationStatus::Converged);
    EXPECT_LT((light.light.intensity - kIntensity).norm(), 1e-8 * kIntensity.norm());
  }
}

TEST(LambertianLights, AmbientAndVignettingAreFoundWithThem) {
  const Scene scene{.ambient = 0.02, .vignetting = {-0.2, 0.03}};
  const LambertianLightResult result = solve(4, scene, {.albedo = 0.8, .has_ambient = true, .has_vignetting = true});
  EXPECT_LT(worst_mm(result), 1e-4);
  EXPECT_LT((result.vignetting - scene.vignetting).norm(), 1e-6);
  EXPECT_LT((result.ambient - Vec3::Constant(0.02)).norm(), 1e-8);
}

TEST(LambertianLights, TenPosesOfAPlaneReachTheGoalAndTheirCovarianceHolds) {
  // What rounding to 8 sRGB bits does to values of 0.28 (steps of 0.0045 / sqrt(12)); each of 400 samples a pose is one
  // pixel.
  constexpr double kNoise = 0.0013;
  constexpr int kTrials = 3;
  double squares = 0.0, mahalanobis = 0.0;
  for (std::uint64_t trial = 1; trial <= kTrials; ++trial) {
    const LambertianLightResult result = solve(10, {.noise = kNoise}, {.albedo = 0.8}, trial);
    EXPECT_NEAR(result.sigma, kNoise, 0.1 * kNoise);
    for (std::size_t k = 0; k < kPositions.size(); ++k) {
      const Vec3 error = result.lights[k].light.position - kPositions[k];
      squares += error.squaredNorm();
      mahalanobis += error.dot(result.lights[k].covariance.topLeftCorner<3, 3>().inverse() * error);
    }
  }
  const double n = kTrials * static_cast<double>(kPositions.size());
  std::printf("plane, 10 poses: %.3f mm, normalized %.2f\n", std::sqrt(squares / n), mahalanobis / n);
  EXPECT_LT(std::sqrt(squares / n), 0.2);
  EXPECT_NEAR(mahalanobis / n, 3.0, 4.0 * std::sqrt(6.0 / n));
}

TEST(LambertianLights, VignettingFittedAlongKeepsTheGoal) {
  const Scene scene{.vignetting = {-0.01, 0.0}, .noise = 0.0013};
  const double blind = worst_mm(solve(10, scene, {.albedo = 0.8}));
  const double fitted = worst_mm(solve(10, scene, {.albedo = 0.8, .has_vignetting = true}));
  std::printf("1 %% vignetting: %.3f mm fitted along, %.3f mm when not\n", fitted, blind);
  EXPECT_LT(fitted, 0.5);
  const double strong =
      worst_mm(solve(10, {.vignetting = {-0.3, 0.05}, .noise = 0.0013}, {.albedo = 0.8, .has_vignetting = true}));
  EXPECT_LT(strong, 0.5);
}

TEST(LambertianLights, OneFlatPoseOfAFarLightLeavesTheDistanceOpenAndSaysSo) {
  const Camera camera = camera_above();
  const Vec3 far = 4000.0 * Vec3(0.2, 0.1, 1.0).normalized();
  std::vector<ShadedSample> samples = planes(camera, far, 1, {}, 1);
  RandomStream random(3, 0, 0);
  for (ShadedSample& s : samples)
    s.value *= 150.0, s.value += 0.002 * Vec3(random.normal(), random.normal(), random.normal());
  const LambertianLightResult result = lights_from_lambertian(camera, {samples});
  EXPECT_EQ(result.lights[0].status, CalibrationStatus::Undetermined);
  EXPECT_GT(result.lights[0].distance_sd, 0.1);
  // One light over ten poses: still far, but its direction is known.
  samples = planes(camera, far, 10, {}, 1);
  for (ShadedSample& s : samples)
    s.value *= 150.0, s.value += 0.002 * Vec3(random.normal(), random.normal(), random.normal());
  const Vec3 found = lights_from_lambertian(camera, {samples}).lights[0].light.position;
  EXPECT_LT(std::acos(found.normalized().dot(far.normalized())) * 180 / kPi, 0.5);
}

TEST(LambertianLights, ShadowsAndHighlightsPullLittle) {
  std::vector<std::vector<ShadedSample>> samples;
  for (const Vec3& position : kPositions) {
    samples.push_back(planes(camera_above(), position, 10, {.noise = 0.0013}, 5));
    for (std::size_t i = 0; i < samples.back().size(); i += 25) samples.back()[i].value *= i % 2 == 0 ? 0.1 : 1.8;
  }
  EXPECT_LT(worst_mm(lights_from_lambertian(camera_above(), samples, {.albedo = 0.8})), 0.6);
}

TEST(LambertianLights, ALightBehindTheObjectIsNamed) {
  // The upper half of a ball of 50 mm, seen from above; the light stands below its equator, so that a few samples at
  // the rim are all it reaches.
  const auto ball = [](const Vec3& light) {
    std::vector<ShadedSample> samples;
    for (int i = 0; i < 800; ++i) {
      const double z = (i + 0.5) / 800, turn = 2.399963229728653 * i, flat = std::sqrt(1.0 - z * z);
      ShadedSample s;
      s.normal = Vec3(flat * std::cos(turn), flat * std::sin(turn), z);
      s.point_mm = 50.0 * s.normal;
      s.pixel = *camera_above().project(s.point_mm);
      const Vec3 to_light = light - s.point_mm;
      s.value = 0.8 / kPi * kIntensity * std::max(0.0, to_light.normalized().dot(s.normal)) / to_light.squaredNorm();
      samples.push_back(s);
    }
    return samples;
  };
  const auto error = [&](const Vec3& light) {
    return error_of([&] { (void)lights_from_lambertian(camera_above(), {ball(kPositions[0]), ball(light)}); });
  };
  EXPECT_EQ(error({150, 0, 250}), "");
  const std::string behind = error({100, 0, -400});
  EXPECT_TRUE(has(behind, "light 2 lies behind the object")) << behind;
}

TEST(LambertianLights, BlackWhiteAndWrongSamplesAreNamed) {
  const auto error = [](const auto& change) {
    std::vector<ShadedSample> samples = planes(camera_above(), kPositions[0], 2, {}, 1);
    change(samples);
    return error_of([&] { (void)lights_from_lambertian(camera_above(), {samples}); });
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_TRUE(has(error([](auto& s) { s.resize(10); }), "light 1: too few samples"));
  EXPECT_TRUE(has(error([](auto& s) {
                    for (auto& v : s) v.value.setZero();
                  }),
                  "light 1: the photographs are black"));
  EXPECT_TRUE(has(error([](auto& s) {
                    for (auto& v : s) v.value.setOnes();
                  }),
                  "light 1: nearly all samples are saturated"));
  EXPECT_TRUE(has(error([](auto& s) { s[3].normal *= 2; }), "normal is not of length 1"));
  EXPECT_TRUE(has(error([](auto& s) { s[3].value[1] = std::nan(""); }), "not finite"));
  EXPECT_TRUE(has(error_of([] { (void)lights_from_lambertian(camera_above(), {}); }), "at least one light"));
}

}  // namespace
}  // namespace patinate::capture
