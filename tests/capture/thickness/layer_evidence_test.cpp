#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "capture/thickness/thickness_warnings.h"
#include "libcommon/core/median.h"
#include "libcommon/core/random.h"
#include "patinate/capture/thickness.h"

namespace patinate::capture {
namespace {

constexpr float kPaint = 0.4f, kGlass = 0.95f;
constexpr double kWindow_px = 12.0;

/// Paint with noise, and cracks of clear glass: 2 of 20 columns.
ImageF cracked_layer(int side) {
  ImageF photo(side, side);
  RandomStream random(5, 0);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const float noise = 0.005f * static_cast<float>(random.normal());
      photo.at(x, y) = ((x + y / 4) % 20 < 2 ? kGlass : kPaint) + noise;
    }
  }
  return photo;
}

/// Layer with a round hole in its middle.
ImageF layer_with_hole(int side, double diameter_px) {
  ImageF photo = cracked_layer(side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x)
      if (std::hypot(x - 0.5 * side, y - 0.5 * side) < 0.5 * diameter_px) photo.at(x, y) = kGlass;
  }
  return photo;
}

ThicknessOptions with_window(double sigma_px) {
  ThicknessOptions options;
  options.mode_filter.spatial_sigma_px = sigma_px;
  return options;
}

std::vector<HistoryWarning> warnings_of(const ThicknessMap& map, const ThicknessOptions& options) {
  return thickness_warnings(map.evidence, "light.png", options);
}

TEST(LayerEvidence, TheCommonestValueOfACrackedLayerCoversWhatIsNotCracked) {
  const ThicknessOptions options = with_window(kWindow_px);
  const ThicknessMap map = thickness_from_transmission(cracked_layer(160), {}, {}, options);
  // 18 of 20 columns; a window's smoothing leaves 1.2 % out, the pattern within it varies by as much.
  EXPECT_NEAR(map.evidence.share, 0.9, 0.03);
  EXPECT_EQ(map.evidence.two_modes, 0.0);
  EXPECT_EQ(map.evidence.hole_share, 0.0);
  // One of two neighbors is in a crack in 20 % of the pairs, so that the median is the others' 62.5th percentile:
  // 0.887 / 0.6745 of what it would be. 4 sigma of it for 25,000 pairs.
  EXPECT_NEAR(map.evidence.noise, 0.005 * 0.887 / 0.6745, 0.0003);
  EXPECT_TRUE(warnings_of(map, options).empty());
}

TEST(LayerEvidence, AHoleNarrowerThanTheWindowIsFilledWithoutAWord) {
  const ThicknessOptions options = with_window(kWindow_px);
  // A disc of this diameter holds 1 - exp(-d^2 / 8 sigma^2) = 22 % of a window at its center.
  const ThicknessMap map = thickness_from_transmission(layer_with_hole(160, 17.0), {}, {}, options);
  EXPECT_NEAR(map.values.at(80, 80), 1.0f / kPaint, 0.05f);
  EXPECT_TRUE(warnings_of(map, options).empty());
}

TEST(LayerEvidence, AHoleWiderThanTheWindowIsNamedWithAWindowThatFillsIt) {
  const ThicknessOptions options = with_window(kWindow_px);
  const ImageF photo = layer_with_hole(256, 60.0);
  const ThicknessMap map = thickness_from_transmission(photo, {}, {}, options);
  EXPECT_NEAR(map.evidence.hole_share, 0.25 * std::numbers::pi * 60.0 * 60.0 / (256.0 * 256.0), 0.01);
  EXPECT_NEAR(map.evidence.hole_width_px, 60.0, 4.0);
  const auto warnings = warnings_of(map, options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].about, WarningSubject::Control);
  EXPECT_NE(warnings[0].text.find("missing in 4."), std::string::npos) << warnings[0].text;
  EXPECT_NE(warnings[0].cure.find("--spatial-sigma"), std::string::npos) << warnings[0].cure;
  ASSERT_GT(map.evidence.filling_sigma_px, kWindow_px);
  const ThicknessOptions proposed = with_window(map.evidence.filling_sigma_px);
  const ThicknessMap filled = thickness_from_transmission(photo, {}, {}, proposed);
  EXPECT_NEAR(filled.values.at(128, 128), 1.0f / kPaint, 0.05f);
  EXPECT_TRUE(warnings_of(filled, proposed).empty());
}

TEST(LayerEvidence, HalfALayerThatIsGoneIsToBeMaskedAndNotFilled) {
  ImageF photo = cracked_layer(160);
  for (int y = 0; y < 160; ++y) std::fill_n(&photo.at(80, y), 80, kGlass);
  const ThicknessOptions options = with_window(kWindow_px);
  const ThicknessMap map = thickness_from_transmission(photo, {}, {}, options);
  EXPECT_NEAR(map.evidence.hole_share, 0.5, 0.02);
  EXPECT_EQ(map.evidence.filling_sigma_px, 0.0);
  const auto warnings = warnings_of(map, options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].cure.find("mask"), std::string::npos) << warnings[0].cure;
  EXPECT_EQ(warnings[0].cure.find("--spatial-sigma"), std::string::npos) << warnings[0].cure;
}

TEST(LayerEvidence, SlopingPaintIsNoHole) {
  ImageF photo = cracked_layer(160);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 160; ++x) photo.at(x, y) = photo.at(x, y) * (0.8f + 0.4f * static_cast<float>(x) / 160.0f);
  const ThicknessOptions options = with_window(kWindow_px);
  const ThicknessMap map = thickness_from_transmission(photo, {}, {}, options);
  EXPECT_EQ(map.evidence.hole_share, 0.0);
  EXPECT_TRUE(warnings_of(map, options).empty());
}

TEST(LayerEvidence, NoiseBeyondTheRangeIsNamedWithARangeThatSuits) {
  ImageF photo(128, 128);
  RandomStream random(6, 0);
  for (float& v : photo.values()) v = 0.5f + 0.09f * static_cast<float>(random.normal());
  const ThicknessOptions options = with_window(kWindow_px);
  const ThicknessMap map = thickness_from_transmission(photo, {}, {}, options);
  const auto warnings = warnings_of(map, options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].text.find("less than half of its window"), std::string::npos) << warnings[0].text;
  EXPECT_NE(warnings[0].cure.find("--range-sigma 0.09"), std::string::npos) << warnings[0].cure;
}

/// Paint that curves with a period, with noise of 0.5 %, and cracks of clear glass: `width_px` of 40 columns.
ImageF curved_layer(int width_px, double period_px) {
  constexpr int kSide = 320;
  ImageF photo(kSide, kSide);
  RandomStream random(7, 0);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double paint =
          static_cast<double>(kPaint) * (1.0 + 0.25 * std::sin(2.0 * std::numbers::pi * y / period_px));
      const double light = (x + y / 4) % 40 < width_px ? static_cast<double>(kGlass) : paint;
      photo.at(x, y) = static_cast<float>(light + 0.002 * random.normal());
    }
  }
  return photo;
}

TEST(LayerWindow, IsNarrowWhereTheLayerCurvesAndWideWhereItsCracksAre) {
  const LayerWindow curved = choose_layer_window(curved_layer(2, 80.0), {}, {}),
                    cracked = choose_layer_window(curved_layer(18, 1e6), {}, {});
  EXPECT_TRUE(curved.is_chosen);
  EXPECT_TRUE(cracked.is_chosen);
  // A window of a quarter of the period averages the curve away; one that is narrower than the cracks locks onto them.
  EXPECT_LT(curved.sigma_px, 80.0 / 4.0);
  EXPECT_GE(cracked.sigma_px, 18.0);
  EXPECT_NEAR(cracked.gap_px, 18, 3);
}

TEST(LayerWindow, OfACurvedLayerLeavesLessThanHalfOfTheErrorOfTheOneNobodyChose) {
  const ImageF photo = curved_layer(2, 80.0);
  const auto error_with = [&](std::optional<double> sigma) {
    ThicknessOptions options{.curve = ThicknessCurve::Linear};
    options.mode_filter.spatial_sigma_px = sigma;
    const ThicknessMap map = thickness_from_transmission(photo, {}, {}, options);
    std::vector<double> errors;
    for (int y = 20; y < photo.height() - 20; ++y) {
      const double paint = static_cast<double>(kPaint) * (1.0 + 0.25 * std::sin(2.0 * std::numbers::pi * y / 80.0));
      for (int x = 20; x < photo.width() - 20; ++x)
        errors.push_back(std::abs(1.0 - static_cast<double>(map.values.at(x, y)) - paint));
    }
    return median(std::move(errors));
  };
  const double chosen = error_with({});
  // A window averages a curve with the square of its width: one that is narrower by 1.5, the step between windows that
  // are tried, has less than half of the error.
  EXPECT_LT(chosen, 0.5 * error_with(kModeFilterWindow_px));
}

TEST(LayerWindow, ThatIsGivenIsKeptAndASmallLayerIsNotAsked) {
  const ThicknessMap map = thickness_from_transmission(cracked_layer(160), {}, {}, with_window(kWindow_px));
  EXPECT_FALSE(map.window.is_chosen);
  EXPECT_EQ(map.window.sigma_px, kWindow_px);
  EXPECT_EQ(layer_window_text(map.window), "");
  EXPECT_FALSE(choose_layer_window(cracked_layer(40), {}, {}).is_chosen);
}

TEST(ModeFilterShares, AreThoseOfTwoValuesThatMeetAtAnEdge) {
  ImageF in(96, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 96; ++x) in.at(x, y) = x < 48 ? 0.3f : 0.7f;
  const ModeFilterOptions options{.spatial_sigma_px = 6.0};
  const ModeFilterResult result = mode_filter_shares(in, {}, options);
  EXPECT_EQ(result.values, mode_filter(in, {}, options));
  // The normal distribution from the pixel's center to the edge: 3.5 px are 0.583 sigma, 72.0 %; discretization as in
  // ModeFilter.ReachesTheHighestPeakOfTheExactHistogram, 1.2 % beyond the peak's reach.
  EXPECT_NEAR(result.share.at(44, 24), 0.72, 0.03);
  EXPECT_NEAR(result.second_share.at(44, 24), 0.28, 0.03);
  EXPECT_NEAR(result.second_value.at(44, 24), 0.7f, 0.4f / 123.0f);  // A bin.
  EXPECT_GT(result.share.at(5, 24), 0.98);
  EXPECT_EQ(result.second_share.at(5, 24), 0.0f);
}

}  // namespace
}  // namespace patinate::capture
