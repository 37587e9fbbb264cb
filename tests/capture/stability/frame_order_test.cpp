#include "capture/stability/frame_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "libcommon/core/random.h"
#include "tests/capture/stability/stability_scene.h"

namespace patinate::capture {
namespace {

constexpr int kNumLooks = 24;

/// Of a surface of whose places a third darkens, one after another; each photograph with a light of its own. (Where all
/// of them darken alike, the end looks like the beginning in another light.)
std::vector<FrameLook> aging(double grain, std::uint64_t seed = 1) {
  std::vector<FrameLook> looks;
  for (int i = 0; i < kNumLooks; ++i) {
    RandomStream random(seed, static_cast<std::uint64_t>(i));
    FrameLook look{};
    const double light = std::exp(0.2 * random.normal());
    for (std::size_t k = 0; k < look.size(); ++k) {
      const double onset = static_cast<double>((37 * k) % look.size()) / static_cast<double>(look.size());
      const double aged = k % 3 == 0 ? std::clamp(2.0 * i / kNumLooks - onset, 0.0, 1.0) : 0.0;
      for (std::size_t c = 0; c < 3; ++c)
        look[k][c] = static_cast<float>(0.4 * light * (1.0 - 0.5 * aged) * std::exp(grain * random.normal()));
    }
    looks.push_back(look);
  }
  return looks;
}

std::vector<FrameLook> in_order(const std::vector<FrameLook>& looks, const std::vector<int>& order) {
  std::vector<FrameLook> out;
  for (int i : order) out.push_back(looks[i]);
  return out;
}

std::vector<int> shuffled(std::uint64_t seed) {
  std::vector<int> order(kNumLooks);
  std::iota(order.begin(), order.end(), 0);
  RandomStream random(seed, 7);
  for (std::size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[random.below(static_cast<std::uint32_t>(i + 1))]);
  return order;
}

TEST(FrameOrder, OfAgingIsTheOneGivenWhateverTheLight) {
  for (double grain : {0.0, 0.01, 0.05}) {
    const FrameOrder order = find_order(aging(grain));
    EXPECT_FALSE(order.is_disordered()) << grain;
    EXPECT_NEAR(order.detour, 1.0, 1e-9 + 4.0 * grain);  // Grain makes short cuts.
  }
}

TEST(FrameOrder, OfShuffledPhotographsIsTheTrueOneFromEitherEnd) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<int> shown = shuffled(seed);
    const FrameOrder order = find_order(in_order(aging(0.01), shown));
    EXPECT_TRUE(order.is_disordered());
    std::vector<int> truth;
    for (int k : order.best) truth.push_back(shown[k]);
    if (truth.front() > truth.back()) std::reverse(truth.begin(), truth.end());
    EXPECT_TRUE(std::is_sorted(truth.begin(), truth.end())) << seed;
    // Two places drawn from n are 8 / 15 sqrt(n) apart on the mean where differences add in squares; half of that.
    EXPECT_GT(order.detour, 4.0 / 15.0 * std::sqrt(kNumLooks));
  }
}

// "1, 10, 11, ... 2, 20, ...": what sorting names by letters does.
TEST(FrameOrder, OfNamesSortedByLettersIsNotedToBeWrong) {
  std::vector<int> order(kNumLooks);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [](int a, int b) { return std::to_string(a + 1) < std::to_string(b + 1); });
  EXPECT_TRUE(find_order(in_order(aging(0.01), order)).is_disordered());
}

TEST(FrameOrder, OfPhotographsThatDoNotAgeIsNoMatter) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<FrameLook> looks(kNumLooks, aging(0.0)[0]);
    RandomStream random(seed, 3);
    for (FrameLook& look : looks) {
      for (auto& place : look) {
        for (float& v : place) v *= static_cast<float>(std::exp(0.02 * random.normal()));
      }
    }
    EXPECT_FALSE(find_order(looks).is_disordered()) << seed;
  }
}

TEST(FrameOrder, IsOfThoseThatBelong) {
  std::vector<FrameLook> looks = aging(0.01);
  RandomStream random(1, 1);
  for (auto& place : looks[11]) place = {0.5f * static_cast<float>(random.uniform()), 0.1f, 0.9f};
  const FrameOrder order = find_order(looks, {11});
  EXPECT_FALSE(order.is_disordered());
  EXPECT_EQ(order.best.size(), static_cast<std::size_t>(kNumLooks - 1));
  EXPECT_EQ(std::count(order.best.begin(), order.best.end(), 11), 0);
}

TEST(FrameOrder, OfAThousandPhotographsIsThatOfSome) {
  std::vector<FrameLook> looks;
  const std::vector<FrameLook> some = aging(0.01);
  for (int i = 0; i < 1000; ++i) looks.push_back(some[i * kNumLooks / 1000]);
  const FrameOrder order = find_order(looks);
  EXPECT_EQ(order.best.size(), 256u);
  EXPECT_FALSE(order.is_disordered());
}

TEST(FrameOrder, LooksAreMeansOfPlacesAndComeBackFromFiles) {
  const PreparedFrame frame = prepare_frame(testing_support::render_scene({.growth = 0.5}));
  const FrameLook look = frame_look(frame);
  double sum = 0.0, mean = 0.0;
  for (const auto& place : look) sum += static_cast<double>(place[1]) / static_cast<double>(look.size());
  for (std::int64_t i = 0; i < frame.light.num_pixels(); ++i)
    mean += static_cast<double>(frame.light.data()[3 * i + 1]) / static_cast<double>(frame.light.num_pixels());
  EXPECT_NEAR(sum, mean, 1e-3);  // Places differ in size by a row at most.
  const Json json = look_to_json(look);
  const FrameLook again = look_from_json(JsonReader("look", json));
  for (std::size_t k = 0; k < look.size(); ++k)
    EXPECT_NEAR(again[k][2], look[k][2], 0.51e-4);  // They are in units of 1e-4.
}

}  // namespace
}  // namespace patinate::capture
