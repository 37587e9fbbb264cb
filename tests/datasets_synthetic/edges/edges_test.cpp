#include "datasets_synthetic/edges.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::datasets {
namespace {

constexpr EdgesOptions kSmall{.patch_px = 16};

int number_of(std::string_view name) {
  for (std::size_t i = 0; i < kEdgePatches.size(); ++i) {
    if (kEdgePatches[i].name == name) return static_cast<int>(i);
  }
  ADD_FAILURE() << name;
  return -1;
}

/// Middle of a patch.
std::array<int, 2> middle(int patch) {
  const int step = 16 + 5;
  return {5 + patch % 4 * step + 8, 5 + patch / 4 * step + 8};
}

TEST(Edges, EveryPatchHasItsPlaceAndItsArea) {
  std::array<int, kEdgePatches.size()> areas{};
  for (int y = 0; y < edges_side(kSmall); ++y) {
    for (int x = 0; x < edges_side(kSmall); ++x) {
      const int patch = edge_patch_at(kSmall, x, y);
      if (patch >= 0) ++areas.at(static_cast<std::size_t>(patch));
    }
  }
  for (const int area : areas) EXPECT_EQ(area, 16 * 16);
  for (int patch = 0; patch < static_cast<int>(kEdgePatches.size()); ++patch) {
    const auto [x, y] = middle(patch);
    EXPECT_EQ(edge_patch_at(kSmall, x, y), patch);
  }
}

TEST(Edges, CoursesAreWhatTheirNamesSay) {
  const int last = static_cast<int>(kEdgeTimes.size()) - 1;
  for (int i = 0; i <= last; ++i) {
    EXPECT_EQ(edge_course(number_of("step_first"), i), i >= 1);
    EXPECT_EQ(edge_course(number_of("step_last"), i), i == last);
    EXPECT_EQ(edge_course(number_of("constant"), i), 0.0);
    EXPECT_DOUBLE_EQ(edge_course(number_of("even"), i), kEdgeTimes[i] / 100.0);
  }
  EXPECT_EQ(edge_course(number_of("wiped"), last), 0.0);
  EXPECT_EQ(edge_course(number_of("wiped"), 9), 1.0) << "at 50 h";
  EXPECT_EQ(edge_course(number_of("spoilt_once"), 7), 1.0) << "at 11 h";
}

TEST(Edges, FaintIsLessThanACodeAndNotNothing) {
  const auto [x, y] = middle(number_of("faint"));
  const Vec3 first = edge_color(kSmall, x, y, 0), last = edge_color(kSmall, x, y, 11);
  for (int c = 0; c < 3; ++c) {
    const float change = srgb_from_linear(static_cast<float>(last[c])) - srgb_from_linear(static_cast<float>(first[c]));
    EXPECT_NEAR(255.0f * change, 0.5f, 1e-3f);  // Rounding of floats.
  }
}

TEST(Edges, HalvesOfTheChessboardAreOneColorTogetherAtAllTimes) {
  const auto [x, y] = middle(number_of("chessboard"));
  for (int i = 0; i < static_cast<int>(kEdgeTimes.size()); ++i) {
    const Vec3 mean = 0.5 * (edge_color(kSmall, x, y, i) + edge_color(kSmall, x + 1, y, i));
    EXPECT_LT((mean - 0.5 * (edge_color(kSmall, x, y, 0) + edge_color(kSmall, x + 1, y, 0))).norm(), 1e-12);
  }
}

TEST(Edges, OptionsOutOfRangeAreRefused) { EXPECT_THROW((void)plan_edges({.patch_px = 8}, "x"), InvalidInput); }

}  // namespace
}  // namespace patinate::datasets
