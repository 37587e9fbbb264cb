#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "capture/relief/relief_change.h"
#include "capture/relief/relief_figures.h"
#include "capture/relief/stable_pose.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"

namespace patinate::capture {
namespace {

constexpr double kNoise_mm = 0.05;

/// A tooled plate with furrows of 0.15 mm, without symmetry.
double plate(double x, double y) {
  return 0.15 * std::sin(1.3 * x + 0.4 * y) + 0.1 * std::cos(0.9 * y - 0.2 * x * y * 0.1) + 0.02 * x;
}

/// 20 mm x 10 mm at a spacing of 0.1 mm, from points that no other scan has. @param change  Added to the height.
PointCloud plate_scan(std::uint64_t seed, const std::function<double(double, double)>& change,
                      double noise = kNoise_mm) {
  PointCloud cloud;
  cloud.toward_scanner = Vec3::UnitZ();
  for (int j = 0; j < 100; ++j) {
    for (int i = 0; i < 200; ++i) {
      RandomStream random(seed, static_cast<std::uint64_t>(j * 200 + i), 7);
      const double x = (i + random.uniform()) * 0.1 - 10.0, y = (j + random.uniform()) * 0.1 - 5.0;
      cloud.points.emplace_back(x, y, plate(x, y) + change(x, y) + noise * random.normal());
    }
  }
  return cloud;
}

double none(double, double) { return 0.0; }
/// 20 micrometers are lost from the right half, 1 cm2.
double half_lost(double x, double) { return x > 0.0 ? -0.020 : 0.0; }

/// Error that a registration leaves: 0.03 degrees and 15 micrometers.
RigidTransform small_error() { return {rotation_of({4e-4, -3e-4, 1e-4}), {0.01, -0.006, 0.015}}; }

ImageU8 left_half(const ReliefView& view) {
  ImageU8 stable(view.width, view.height);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) stable.at(x, y) = view.at(x, y).x() < -0.3 ? 255 : 0;
  }
  return stable;
}

Relief relief_of(const PointCloud& before, PointCloud after, const ReliefOptions& options,
                 const std::function<ImageU8(const ReliefView&)>& stable = {}) {
  const std::vector<PointCloud> scans{before, moved(std::move(after), small_error().inverse())};
  // The given pose is the identity: wrong by the small error.
  return measure_relief(scans, std::vector<RigidTransform>(2), 0, stable, options);
}

struct Mean {
  double change = 0.0;
  int n = 0;
};
Mean mean_where(const Relief& relief, const std::function<bool(double x)>& counts) {
  Mean mean;
  for (int y = 0; y < relief.view.height; ++y) {
    for (int x = 0; x < relief.view.width; ++x) {
      if (relief.changes[0].measured.at(x, y) == 0 || !counts(relief.view.at(x, y).x())) continue;
      mean.change += static_cast<double>(relief.changes[0].change_mm.at(x, y)), ++mean.n;
    }
  }
  mean.change /= mean.n;
  return mean;
}

TEST(HeightChange, TwentyMicrometersLostFromHalfOfASurfaceAreMeasuredToThree) {
  const Relief relief = relief_of(plate_scan(1, none), plate_scan(2, half_lost), {}, left_half);
  const double half_window = 0.5 * relief.window_mm;
  const Mean lost = mean_where(relief, [&](double x) { return x > half_window; });
  const Mean kept = mean_where(relief, [&](double x) { return x < -half_window; });
  // The goal of the issue: 3 micrometers at 0.05 mm of noise over 1 cm2.
  EXPECT_NEAR(lost.change, -0.020, 0.003);
  EXPECT_NEAR(kept.change, 0.0, 0.003);
  // 200 mm3 per meter: 0.02 mm of 1 cm2 and a little, for the furrows are longer than flat; to 3 deviations.
  const ReliefChange& change = relief.changes[0];
  EXPECT_NEAR(change.net.mm3 / change.net.area_mm2, -0.010, 3.0 * change.net.stddev_mm3 / change.net.area_mm2 + 2e-4);
  EXPECT_LT(change.net.stddev_mm3 / change.net.area_mm2, 0.003);
}

TEST(HeightChange, RegistrationIsNotPulledAlongByAChangeOfAThirdWithoutAMask) {
  const auto lost = [](double x, double) { return x > 3.4 ? -0.060 : 0.0; };
  const Relief relief = relief_of(plate_scan(3, none), plate_scan(4, lost), {});
  // The place of the changed third follows from the turn of the rest, and is known as well as the deviation says.
  const VolumeChange& lost_volume = relief.changes[0].lost;
  const double deviation = lost_volume.stddev_mm3 / lost_volume.area_mm2;
  EXPECT_LT(deviation, 0.006);
  EXPECT_NEAR(mean_where(relief, [](double x) { return x > 4.0; }).change, -0.060, 3.0 * deviation);
  EXPECT_NEAR(mean_where(relief, [](double x) { return x < 3.0; }).change, 0.0, 0.003);
  EXPECT_NEAR(relief.changes[0].stable_share, 0.67, 0.1);
}

TEST(HeightChange, DeviationsCoverTheTruth) {
  int n = 0, covered = 0;
  for (std::uint64_t seed = 10; seed < 16; ++seed) {
    const Relief relief = relief_of(plate_scan(seed, none), plate_scan(100 + seed, none), {});
    const int stride = static_cast<int>(std::ceil(relief.window_mm / relief.view.texel));
    const ReliefChange& change = relief.changes[0];
    for (int y = 0; y < relief.view.height; y += stride) {
      for (int x = 0; x < relief.view.width; x += stride) {
        if (change.measured.at(x, y) == 0) continue;
        ++n;
        covered += std::abs(change.change_mm.at(x, y)) <= 1.96f * change.stddev_mm.at(x, y) ? 1 : 0;
      }
    }
  }
  // Independent places: 0.95 to four standard deviations of a binomial.
  EXPECT_NEAR(static_cast<double>(covered) / n, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / n)) << n;
}

TEST(HeightChange, AShallowChangeDoesNotPullTheScanAlong) {
  // Four deviations of a window deep: within the noise of many single places.
  const auto groove = [](double x, double y) { return std::abs(y) < 1.5 && std::abs(x) < 6.0 ? -0.030 : 0.0; };
  constexpr double kLost_mm3 = 0.030 * 3.0 * 12.0;
  constexpr int kRuns = 6;
  double z = 0.0;
  for (std::uint64_t seed = 40; seed < 40 + kRuns; ++seed) {
    const Relief relief = relief_of(plate_scan(seed, none, 0.03), plate_scan(100 + seed, groove, 0.03), {});
    const VolumeChange& net = relief.changes[0].net;
    z += (net.mm3 + kLost_mm3) / net.stddev_mm3;
  }
  // The mean of six, to three of its standard deviations.
  EXPECT_LT(std::abs(z / kRuns), 3.0 / std::sqrt(kRuns));
}

TEST(HeightChange, OfUnchangedSurfacesAlmostNothingIsSignificant) {
  double changed = 0.0;
  for (std::uint64_t seed = 20; seed < 26; ++seed)
    changed += relief_of(plate_scan(seed, none), plate_scan(100 + seed, none), {}).changes[0].changed_share;
  // Where nothing changed, the procedure finds anything at all in one of 20 maps.
  EXPECT_LT(changed / 6.0, 0.01);
}

TEST(HeightChange, OfExactScansIsExact) {
  const auto lost = [](double x, double) { return x > 3.0 ? -0.1 : 0.0; };
  PointCloud before = plate_scan(30, none, 0.0), after = before;
  for (Vec3& p : after.points) p.z() += lost(p.x(), p.y());
  const Relief relief =
      measure_relief(std::vector<PointCloud>{before, after}, std::vector<RigidTransform>(2), 0, {}, {});
  EXPECT_NEAR(mean_where(relief, [](double x) { return x < 2.0; }).change, 0.0, 1e-9);
  // Along the normal, which furrows tilt by up to 14 degrees.
  const double most_tilted = std::cos(14.0 * 3.14159265358979 / 180.0);
  const double mean = mean_where(relief, [](double x) { return x > 4.0; }).change;
  EXPECT_LT(mean, -0.1 * most_tilted);
  EXPECT_GT(mean, -0.1 - 1e-9);
}

TEST(StablePose, AMotionIsFoundAndAPlatesShiftsAreLeftAlone) {
  std::vector<HeightDifference> differences;
  RandomStream random(1, 0);
  for (int i = 0; i < 400; ++i) {
    const Vec3 place(10.0 * random.uniform() - 5.0, 10.0 * random.uniform() - 5.0, 0.0);
    const double lifted = i % 3 == 0 ? 0.5 : 0.0;
    differences.push_back({raising_row(place, Vec3::UnitZ()),
                           0.1 + 0.02 * place.x() - 0.01 * place.y() + 0.01 * random.normal() + lifted, 1e-4});
  }
  const StablePose pose = find_stable_pose(differences, 4.0);
  EXPECT_EQ(pose.num_dofs, 3);
  EXPECT_NEAR(pose.motion[5], -0.1, 4e-3);
  EXPECT_NEAR(pose.motion[0], 0.01, 2e-3);
  EXPECT_NEAR(pose.motion[1], 0.02, 2e-3);
  EXPECT_NEAR(pose.motion[2], 0.0, 1e-12);
  EXPECT_NEAR(pose.motion[3], 0.0, 1e-12);
  EXPECT_NEAR(pose.agreeing, 2.0 / 3.0, 0.03);
  EXPECT_NEAR(pose.noise_factor, 1.0, 0.2);
}

TEST(StablePose, TooFewPlacesAreAnError) {
  EXPECT_THROW((void)find_stable_pose(std::vector<HeightDifference>(11), 1.0), InvalidInput);
}

TEST(SignificantP, IsThatOfBenjaminiAndHochberg) {
  // The example of their paper: 15 values, at 0.05 four are found.
  const std::vector<double> p{0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344,
                              0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0000};
  EXPECT_EQ(significant_p(p, 0.05), 0.0095);
  EXPECT_EQ(significant_p({0.5, 0.9}, 0.05), 0.0);
}

}  // namespace
}  // namespace patinate::capture
