#include "simulation/tracing/random_direction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <numbers>

#include "libcommon/core/random.h"
#include "tests/simulation/tracing/chi_square.h"
#include "tests/support/test_data.h"

namespace patinate::simulation {
namespace {

using testing_support::chi_square_limit;
using testing_support::chi_square_of_equal;

TEST(RandomDirection, FastFunctionsAreThoseOfLibm) {
  RandomStream random(1, 0);
  for (int i = 0; i < testing_support::sample_count(100000); ++i) {
    const std::uint32_t n = i < 4 ? static_cast<std::uint32_t>(i) << 30 : random.next_u32();
    const double angle = 2.0 * std::numbers::pi * n * 0x1.0p-32;
    EXPECT_NEAR(sine_cosine_of(n).sine, std::sin(angle), 1e-11);
    EXPECT_NEAR(sine_cosine_of(n).cosine, std::cos(angle), 1e-11);
    const double power = i % 7 == 0 ? 0.0 : std::pow(10.0, -6.0 * random.uniform());
    const double truth = std::pow((n + 0.5) * 0x1.0p-32, power);
    EXPECT_NEAR(uniform_power(n, power), truth, 1e-11 * truth);
  }
}

TEST(RandomDirection, FramesAreRightHandedAndUnit) {
  RandomStream random(2, 0);
  for (int i = 0; i < 1000; ++i) {
    Vec3 w(random.normal(), random.normal(), random.normal());
    if (i == 0) w = {0, 0, 1};
    if (i == 1) w = {0, 0, -1};
    w.normalize();
    const Frame f = frame_around(w);
    EXPECT_LT((f.u.cross(f.v) - w).norm(), 1e-12);
    EXPECT_NEAR(f.u.norm(), 1.0, 1e-12);
    EXPECT_NEAR(f.v.norm(), 1.0, 1e-12);
  }
}

TEST(RandomDirection, PhongLobeHasItsMomentsAndItsDistribution) {
  for (const double n : {0.0, 1.0, 20.0, 100.0}) {
    constexpr int kDraws = 200000;
    const Vec3 axis = Vec3(0.3, -0.8, 0.5).normalized();
    const Frame frame = frame_around(axis);
    RandomStream random(3, static_cast<std::uint64_t>(n));
    double sum = 0.0;
    std::array<double, 20> by_cosine{};
    std::array<double, 16> by_turn{};
    for (int i = 0; i < kDraws; ++i) {
      const std::uint32_t a = random.next_u32();
      const Vec3 d = lobe_direction(axis, n, a, random.next_u32());
      EXPECT_NEAR(d.norm(), 1.0, 1e-9);
      const double cosine = d.dot(axis);
      sum += cosine;
      by_cosine[std::min<std::size_t>(19, static_cast<std::size_t>(20.0 * std::pow(cosine, n + 1.0)))] +=
          1.0;  // the CDF is uniform
      const double turn = std::atan2(d.dot(frame.v), d.dot(frame.u)) / (2.0 * std::numbers::pi) + 0.5;
      by_turn[std::min<std::size_t>(15, static_cast<std::size_t>(16.0 * turn))] += 1.0;
    }
    const double mean = (n + 1.0) / (n + 2.0), variance = (n + 1.0) / (n + 3.0) - mean * mean;
    EXPECT_NEAR(sum / kDraws, mean, 4.0 * std::sqrt(variance / kDraws)) << n;
    EXPECT_LT(chi_square_of_equal(by_cosine), chi_square_limit(19)) << n;
    EXPECT_LT(chi_square_of_equal(by_turn), chi_square_limit(15)) << n;
  }
}

TEST(RandomDirection, ConeIsUniformInSolidAngle) {
  for (const double half_angle : {0.0, 10.0, 90.0, 180.0}) {
    const double least = std::cos(half_angle * std::numbers::pi / 180.0);
    const Vec3 axis = Vec3(-0.1, 0.2, -0.97).normalized();
    RandomStream random(4, static_cast<std::uint64_t>(half_angle));
    std::array<double, 20> by_cosine{};
    for (int i = 0; i < testing_support::sample_count(100000); ++i) {
      const std::uint32_t a = random.next_u32();
      const double cosine = cone_direction(axis, least, a, random.next_u32()).dot(axis);
      ASSERT_GE(cosine, least - 1e-12);
      if (half_angle > 0.0)
        by_cosine[std::min<std::size_t>(19, static_cast<std::size_t>(20.0 * (1.0 - cosine) / (1.0 - least)))] += 1.0;
    }
    if (half_angle > 0.0) {
      EXPECT_LT(chi_square_of_equal(by_cosine), chi_square_limit(19)) << half_angle;
    }
  }
}

}  // namespace
}  // namespace patinate::simulation
