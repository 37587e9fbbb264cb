#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "capture/stability/deflicker.h"
#include "capture/stability/survey.h"
#include "capture/stability/uneven_light.h"
#include "capture/timelapse/light_report.h"
#include "libcommon/core/random.h"
#include "patinate/core/error.h"
#include "tests/capture/stability/stability_scene.h"

namespace patinate::capture {
namespace {

using Ratio = std::array<double, 3>;
using testing_support::render_scene;

/// Places of which a share ages by a random amount of up to `aging`, unlike in each channel, under light times
/// exp(gain), with noise of 1 %.
std::vector<Ratio> aging_places(double share, double aging, const Ratio& gain) {
  std::vector<Ratio> ratios;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    RandomStream random(21, i, 0);
    const double aged = static_cast<double>(i) < 1000.0 * share ? aging * random.uniform() : 0.0;
    Ratio ratio{};
    for (std::size_t c = 0; c < 3; ++c)
      ratio[c] = gain[c] + aged * (0.5 + 0.25 * static_cast<double>(c)) + 0.01 * random.normal();
    ratios.push_back(ratio);
  }
  return ratios;
}

TEST(LightChange, IsWhatThePlacesShareThatDoNotAge) {
  // Truth: 60 % of the places brighten by up to a factor 3; the median says 1.3 and more, the others say 1.
  const LightChange still = find_light_change(aging_places(0.6, 1.1, {0.0, 0.0, 0.0}));
  EXPECT_TRUE(still.is_sure());
  EXPECT_LT(still.size(), 0.01);
  const LightChange tinted = find_light_change(aging_places(0.25, 1.1, {0.0, 0.0, 0.6}));
  EXPECT_TRUE(tinted.is_sure());
  EXPECT_NEAR(tinted.log_gain[2], 0.6, 0.01);
  EXPECT_NEAR(tinted.log_gain[0], 0.0, 0.01);
}

TEST(LightChange, IsNotSureWhereEveryPlaceAgesInItsOwnWay) {
  EXPECT_FALSE(find_light_change(aging_places(1.0, 2.0, {0.0, 0.0, 0.0})).is_sure());
  EXPECT_FALSE(find_light_change({}).is_sure());
}

std::vector<FramePair> rendered_pairs(int num_frames, const std::function<void(int, ImageF&)>& spoil, double growth) {
  std::vector<FramePair> pairs;
  PreparedFrame before;
  for (int i = 0; i < num_frames; ++i) {
    ImageF image = render_scene({.growth = growth * i});
    spoil(i, image);
    PreparedFrame now = prepare_frame(image);
    if (i > 0) pairs.push_back(compare_frames(i - 1, before, i, now, false));
    before = std::move(now);
  }
  return pairs;
}

TEST(Survey, NamesATintedPhotographOfFourAndOfTwoButNoGrowth) {
  for (int num_frames : {2, 4}) {
    const auto tint = [](int i, ImageF& image) {
      for (std::int64_t p = 0; i == 1 && p < image.num_pixels(); ++p) image.data()[3 * p + 2] *= 1.8f;
    };
    const auto findings = judge_frames(rendered_pairs(num_frames, tint, 0.2), 192, 192);
    ASSERT_EQ(findings.size(), num_frames == 2 ? 1u : 2u) << "there, and back again";
    EXPECT_TRUE(findings[0].is_exposure_changed);
    EXPECT_NEAR(findings[0].gain[2], 1.8, 0.02);
    EXPECT_NEAR(findings[0].gain[0], 1.0, 0.02);
    for (const FrameFinding& f : judge_frames(rendered_pairs(
                                                  num_frames, [](int, ImageF&) {}, 0.2),
                                              192, 192))
      EXPECT_FALSE(f.is_exposure_changed) << finding_text(f);
  }
}

TEST(Deflicker, MoldOverMostOfThePictureIsNotDividedOut) {
  // Truth: the light is constant; a textured bluish layer covers two thirds from frame 5 on.
  const auto mold = [](int i, ImageF& image) {
    if (i < 5) return;
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 192; ++x) {
        const float texture = 0.2f + 0.1f * static_cast<float>(std::sin(0.3 * x) * std::cos(0.2 * y));
        image.at(x, y, 0) = texture;
        image.at(x, y, 1) = 1.2f * texture;
        image.at(x, y, 2) = 1.6f * texture;
      }
    }
  };
  const FramePair at_mold = rendered_pairs(6, mold, 0.0).back();
  EXPECT_GT(at_mold.change.log_gain[2], 0.2) << "the median takes it for light";
  EXPECT_TRUE(at_mold.change.light.is_sure());
  EXPECT_LT(at_mold.change.light.size(), 0.01);
}

TEST(Deflicker, OneOfFourIsMendedAloneAtTheEndsToo) {
  for (std::size_t odd : {0u, 1u, 3u}) {
    std::vector<double> curve(4, 0.0);
    curve[odd] = 0.6;
    std::vector<Ratio> gains;
    for (std::size_t i = 1; i < 4; ++i) gains.push_back({0.0, 0.0, curve[i] - curve[i - 1]});
    const auto factors = deflicker_factors(gains);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(factors[i][2], i == odd ? std::exp(-0.6) : 1.0, 1e-6) << odd << i;
  }
}

TEST(Deflicker, WhatIsNotKnownSeparatesTheSeries) {
  const auto factors =
      deflicker_factors({{0.5, 0.5, 0.5}, {-0.3, -0.3, -0.3}, {0.01, 0.01, 0.01}}, {}, {false, true, true});
  EXPECT_NEAR(factors[0][0], 1.0, 1e-12);
  EXPECT_NEAR(factors[1][0], std::exp(-0.29), 1e-9) << "to the middle of the last three";
  EXPECT_NEAR(factors[2][0], std::exp(0.01), 1e-9);
  EXPECT_THROW((void)deflicker_factors({{0, 0, 0}}, {}, {true, false}), InvalidInput);
}

/// 64 x 64: a texture that `time` replaces, times a fall-off of the light, times a slow course of the surface that goes
/// with it; `paint` is a slow course that stays.
ImageF lit_surface(int time, double light, double course, const Ratio& paint) {
  ImageF image(64, 64, 3);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      RandomStream random(31, static_cast<std::uint64_t>(64 * y + x), static_cast<std::uint64_t>(time));
      const double u = x / 63.0, v = y / 63.0, turned = time % 2 == 0 ? v : 1.0 - v;
      const double level = 0.3 * std::exp(0.3 * random.normal() - light * u - course * turned);
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = static_cast<float>(std::min(0.9, level * std::exp(-paint[c] * u)));
    }
  }
  return image;
}

UnevenLight of_series(double light, double course, const Ratio& paint, bool is_replaced) {
  std::vector<ImageF> frames;
  for (int i = 0; i < 6; ++i) frames.push_back(lit_surface(is_replaced ? i / 3 : 0, light, course, paint));
  return find_uneven_light(frames, {});
}

TEST(UnevenLight, IsClearWhereItStayedWhileTheSurfaceWasReplaced) {
  const UnevenLight found = of_series(std::log(1.56), 0.0, {}, true);
  EXPECT_EQ(found.evidence, LightEvidence::Clear);
  // 2 % at either end of a linear course are left out: 1.56^0.96; the fit's error over 4096 pixels of 30 % is 2 %.
  EXPECT_NEAR(found.ratio, std::pow(1.56, 0.96), 0.04);
}

TEST(UnevenLight, IsOnlyPossibleWhereTheSurfaceStays) {
  EXPECT_EQ(of_series(std::log(2.0), 0.0, {}, false).evidence, LightEvidence::Possible);
  EXPECT_EQ(find_uneven_light({lit_surface(0, std::log(2.0), 0.0, {})}, {}).evidence, LightEvidence::Possible);
}

TEST(UnevenLight, IsNoneInEvenLightWhateverTheSurfaceDoes) {
  EXPECT_EQ(of_series(0.0, 0.0, {}, true).evidence, LightEvidence::None);
  EXPECT_EQ(of_series(0.0, 0.7, {}, true).evidence, LightEvidence::None) << "a course that goes with the surface";
  EXPECT_EQ(of_series(0.0, 0.0, {0.9, 0.5, -0.3}, false).evidence, LightEvidence::None) << "a color that stays";
  EXPECT_THROW((void)find_uneven_light({}, {}), InvalidInput);
}

TEST(UnevenLight, OutsideTheMaskNothingCounts) {
  ImageF image = lit_surface(0, 0.0, 0.0, {});
  ImageU8 mask(64, 64, 1, 255);
  for (int y = 0; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) {
      mask.at(x, y) = 0;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) *= 0.2f;
    }
  }
  EXPECT_EQ(find_uneven_light({image}, {}).evidence, LightEvidence::Possible);
  EXPECT_EQ(find_uneven_light({image}, mask).evidence, LightEvidence::None);
}

TEST(UnevenLight, OfASmallObjectInAMaskIsJudgedAsThatOfAWholePicture) {
  // A sixth of the picture, lit 3 : 1 from its left to its right, on a ground of another light.
  constexpr int kFirst = 20, kLast = 45;
  const double light = std::log(3.0) * 63.0 / (kLast - kFirst);
  ImageF image = lit_surface(0, light, 0.0, {});
  ImageU8 mask(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool is_inside = x >= kFirst && x <= kLast && y >= kFirst && y <= kLast;
      mask.at(x, y) = is_inside ? 255 : 0;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = is_inside ? image.at(x, y, c) : 0.9f;
    }
  }
  const UnevenLight found = find_uneven_light({image}, mask);
  EXPECT_EQ(found.evidence, LightEvidence::Possible);
  // 15 coefficients from 676 pixels whose logarithms vary by 0.3; both ends of the course are off by it. 4 deviations.
  EXPECT_NEAR(std::log(found.ratio), 0.96 * std::log(3.0), 4.0 * 0.3 * std::sqrt(2.0 * 15.0 / 676.0));
}

TEST(LightWarnings, SpeakOfNothingThatLiesOutsideTheMask) {
  SeriesLight light;
  light.uneven = UnevenLight{.ratio = 29.0, .evidence = LightEvidence::Possible};
  const std::string whole = light_warnings(light, "", 3).at(0).text;
  light.uneven->is_inside_mask = true;
  const std::string masked = light_warnings(light, "", 3).at(0).text;
  EXPECT_NE(masked.find("29 : 1 inside the mask"), std::string::npos) << masked;
  EXPECT_EQ(masked.find("surroundings"), std::string::npos) << masked;
  EXPECT_NE(whole.find("29 : 1 over the picture"), std::string::npos) << whole;
  EXPECT_NE(whole.find("dark surroundings that belong outside a `mask`"), std::string::npos) << whole;
}

}  // namespace
}  // namespace patinate::capture
