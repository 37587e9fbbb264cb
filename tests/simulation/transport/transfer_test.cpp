#include "simulation/transport/transfer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libcommon/core/random.h"
#include "tests/support/test_data.h"

namespace patinate::simulation {
namespace {

constexpr double kSigmas = 4.0;

/// Mass that goes from a texel to a gammaton, by the solution of the two ODEs as the textbook writes it.
double closed_form(double r, double c, double t, double weight, double texel_mass, double carried) {
  const double k = SurfaceAtlas::kMedianWeight / weight;
  const double lambda = k * (1 - r) + r;
  const double last = k * (1 - r) * (texel_mass + carried) / lambda;
  return (last - carried) * -std::expm1(-c * lambda * t);
}

/// Integral by many small steps of Heun's rule.
double integrated(double r, double c, double t, double weight, double texel_mass, double carried) {
  const double k = SurfaceAtlas::kMedianWeight / weight;
  constexpr int kSteps = 20000;
  double m = texel_mass, g = carried;
  for (int i = 0; i < kSteps; ++i) {
    const double h = t / kSteps;
    const double first = c * (k * (1 - r) * m - r * g);
    const double second = c * (k * (1 - r) * (m - h * first) - r * (g + h * first));
    g += h * (first + second) / 2;
    m -= h * (first + second) / 2;
  }
  return g - carried;
}

TEST(Transfer, SharesAreTheSolutionOfTheEquations) {
  constexpr double kHeun = 1e-6;  // of the mass: error of 20000 second-order steps where c lambda t = 25
  for (const double r : {0.0, 0.3, 1.0}) {
    for (const double weight : {10.0, 256.0, 4096.0}) {
      const TransferShares shares = transfer_shares(r, 0.7, 1.5, static_cast<std::uint32_t>(weight));
      const double texel = 20000 * weight, carried = 9000 * weight;
      const double moved = (shares.up * 20000 - shares.down * carried) * weight;
      EXPECT_NEAR(moved, closed_form(r, 0.7, 1.5, weight, texel, carried), 1e-9 * texel);
      EXPECT_NEAR(moved, integrated(r, 0.7, 1.5, weight, texel, carried), kHeun * texel);
    }
  }
}

TEST(Transfer, TwoHalfContactsAreOneWhole) {
  for (const double r : {0.0, 0.4, 1.0}) {
    const TransferShares whole = transfer_shares(r, 0.5, 2.0, 700), half = transfer_shares(r, 0.5, 1.0, 700);
    double amount = 3000, mass = 9e6;
    for (int i = 0; i < 2; ++i) {
      const double moved = half.up * amount - half.down * mass;
      amount -= moved;
      mass += moved * 700;
    }
    EXPECT_NEAR(3000 - amount, whole.up * 3000 - whole.down * 9e6, 1e-9);
  }
}

TEST(Transfer, MeanIsTheClosedFormForEveryRatioRateAndArea) {
  constexpr int kDraws = 20000;
  RandomStream random(1, 0);
  for (const double r : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    for (const double c : {0.0, 1.0 / 4096, 0.01, 0.3, 1.0}) {
      for (const std::uint32_t weight : {1u, 7u, 100u, 256u, 1000u, 4096u}) {
        const TransferShares shares = transfer_shares(r, c, 1.0, weight);
        const std::uint32_t amount = 20011, mass = 20000 * weight + weight / 3;
        double sum = 0;
        for (int i = 0; i < kDraws; ++i) sum += transfer_quanta(shares, amount, weight, mass, random.next_u32());
        const double expected = closed_form(r, c, 1.0, weight, double(amount) * weight, mass) / weight;
        // Rounding up with probability p has variance p (1 - p) <= 1/4; rounding of the sum in double is far below.
        EXPECT_NEAR(sum / kDraws, expected, kSigmas * 0.5 / std::sqrt(kDraws) + 1e-9 * std::abs(expected))
            << r << " " << c << " " << weight;
      }
    }
  }
}

TEST(Transfer, SmallestRateAndAmountsHaveNoDeadZone) {
  constexpr int kDraws = 2'000'000;
  constexpr double kRate = 1.0 / 4096;
  RandomStream random(2, 0);
  for (const std::uint32_t weight : {64u, 256u, 1024u}) {
    const TransferShares up = transfer_shares(0.0, kRate, 1.0, weight), down = transfer_shares(1.0, kRate, 1.0, weight);
    double picked_up = 0, dropped = 0;
    for (int i = 0; i < kDraws; ++i) {
      picked_up += transfer_quanta(up, 2, weight, 0, random.next_u32());
      dropped -= transfer_quanta(down, 0, weight, 2 * weight, random.next_u32());
    }
    const double up_share = closed_form(0.0, kRate, 1.0, weight, 2.0 * weight, 0.0) / weight;
    const double down_share = -closed_form(1.0, kRate, 1.0, weight, 0.0, 2.0 * weight) / weight;
    EXPECT_NEAR(picked_up / kDraws, up_share,
                kSigmas * std::sqrt(up_share / kDraws));  // so few that they are a Poisson count
    EXPECT_NEAR(dropped / kDraws, down_share, kSigmas * std::sqrt(down_share / kDraws));
  }
}

TEST(Transfer, NeverTakesWhatIsNotThere) {
  RandomStream random(3, 0);
  constexpr double kRatios[] = {0.0, 0.5, 1.0}, kRates[] = {0.0, 0.3, 1.0}, kContacts[] = {0.01, 1.0, 1e6};
  for (int i = 0; i < testing_support::sample_count(1'000'000); ++i) {
    const std::uint32_t weight = 1 + random.below(random.below(2) == 0 ? 300 : SurfaceAtlas::kMaxWeight);
    const std::uint32_t amount =
        random.below(3) == 0 ? kMaxAmount - random.below(3) : random.below(random.below(2) == 0 ? 4 : kMaxAmount + 1);
    const std::uint32_t mass = random.below(3) == 0 ? 0xFFFFFFFFu - random.below(9)
                                                    : random.below(random.below(2) == 0 ? 2 * weight : 0xFFFFFFFFu);
    const TransferShares shares =
        transfer_shares(kRatios[random.below(3)], kRates[random.below(3)], kContacts[random.below(3)], weight);
    const std::int64_t quanta = transfer_quanta(shares, amount, weight, mass, random.next_u32());
    const std::int64_t amount_after = std::int64_t{amount} - quanta, mass_after = std::int64_t{mass} + quanta * weight;
    ASSERT_TRUE(amount_after >= 0 && amount_after <= kMaxAmount && mass_after >= 0 && mass_after <= 0xFFFFFFFF)
        << amount << " x " << weight << ", " << mass << ": " << quanta;
  }
}

TEST(Transfer, RatioZeroOnlyPicksUpAndOneOnlyDrops) {
  RandomStream random(4, 0);
  for (int i = 0; i < testing_support::sample_count(100'000); ++i) {
    const std::uint32_t weight = 1 + random.below(2000), amount = random.below(kMaxAmount + 1),
                        mass = random.next_u32();
    const double rate = random.uniform();
    ASSERT_GE(transfer_quanta(transfer_shares(0.0, rate, 1.0, weight), amount, weight, mass, random.next_u32()), 0);
    ASSERT_LE(transfer_quanta(transfer_shares(1.0, rate, 1.0, weight), amount, weight, mass, random.next_u32()), 0);
  }
}

TEST(Transfer, RandomNumbersBelongToGammatonIterationAndPiece) {
  const auto base = transfer_randoms(5, 17, 3, 0, 8);
  EXPECT_EQ(transfer_randoms(5, 17, 3, 0, 8), base);
  EXPECT_EQ(transfer_randoms(5, 17, 3, 0, 2)[1], base[1]) << "not on how many are wanted";
  for (const auto& other :
       {transfer_randoms(6, 17, 3, 0, 8), transfer_randoms(5, 18, 3, 0, 8), transfer_randoms(5, 17, 4, 0, 8),
        transfer_randoms(5, 17, 3, 1, 8), transfer_randoms(5, 17, 3 + (std::int64_t{1} << 32), 0, 8)}) {
    for (std::size_t i = 0; i < 8; ++i) EXPECT_NE(other[i], base[i]);
  }
}

}  // namespace
}  // namespace patinate::simulation
