#include "libcommon/core/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libcommon/core/random.h"

namespace patinate {
namespace {

TEST(PortableMath, ExpEqualsLibmToSixUnitsInTheLastPlace) {
  RandomStream random(1, 0);
  for (int i = 0; i < 100'000; ++i) {
    const double x = (random.uniform() - 0.5) * (i % 2 == 0 ? 4.0 : 1400.0);
    EXPECT_NEAR(portable_exp(x) / std::exp(x), 1.0, 1.4e-15) << x;
  }
  EXPECT_EQ(portable_exp(0.0), 1.0);
  EXPECT_EQ(portable_exp(-1e9), 0.0);
  EXPECT_TRUE(std::isinf(portable_exp(1e9)));
}

TEST(PortableMath, DecayedKeepsItsPrecisionForTinyTimes) {
  for (double x = 1e-12; x < 50.0; x *= 1.07) EXPECT_NEAR(portable_decayed(x) / -std::expm1(-x), 1.0, 1e-14) << x;
  EXPECT_EQ(portable_decayed(0.0), 0.0);
}

TEST(PortableMath, LogEqualsLibm) {
  RandomStream random(2, 0);
  for (int i = 0; i < 100'000; ++i) {
    const double x = std::exp((random.uniform() - 0.5) * (i % 2 == 0 ? 1.0 : 1000.0));
    EXPECT_NEAR(portable_log(x), std::log(x), 1e-15 * (1.0 + std::abs(std::log(x)))) << x;
  }
  EXPECT_EQ(portable_log(1.0), 0.0);
}

TEST(PortableMath, PowEqualsLibm) {
  RandomStream random(3, 0);
  for (int i = 0; i < 100'000; ++i) {
    const double x = random.uniform() * 3.0;
    const double y = random.uniform() * 20.0;
    if (x < 1e-3) continue;
    EXPECT_NEAR(portable_pow(x, y) / std::pow(x, y), 1.0, 1e-13);  // y log x reaches 138: its last place is 3e-14
  }
  EXPECT_EQ(portable_pow(0.0, 2.0), 0.0);
  EXPECT_EQ(portable_pow(0.0, 0.0), 1.0);
}

TEST(PortableMath, SineAndCosineEqualLibmAndAreExactAtQuarterTurns) {
  RandomStream random(4, 0);
  for (int i = 0; i < 100'000; ++i) {
    const double turns = (random.uniform() - 0.5) * 3.0;
    const SineCosine sc = portable_sine_cosine(turns);
    EXPECT_NEAR(sc.sine, std::sin(2 * std::numbers::pi * turns), 3e-15);
    EXPECT_NEAR(sc.cosine, std::cos(2 * std::numbers::pi * turns), 3e-15);
  }
  for (int q = -8; q <= 8; ++q) {
    const SineCosine sc = portable_sine_cosine(q / 4.0);
    EXPECT_EQ(std::abs(sc.sine), q % 2 == 0 ? 0.0 : 1.0);
    EXPECT_EQ(std::abs(sc.cosine), q % 2 == 0 ? 1.0 : 0.0);
  }
}

}  // namespace
}  // namespace patinate
