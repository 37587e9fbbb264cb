#include "patinate/datasets/panel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "datasets_synthetic/panel_io.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::datasets {
namespace {

constexpr double kSamplesPerMm = 80.0;  ///< 8 a pixel of 0.1 mm, along a side.

/// 30 x 24 mm, 22 x 16 mm of it test area, without noise.
PanelOptions small_panel() { return {.width = 300, .height = 240, .num_frames = 4, .edge_mm = 4.0, .noise = 0.0}; }

double total_share(const ImageF& shares) {
  double total = 0.0;
  for (const float share : shares.values()) total += static_cast<double>(share);
  return total;
}

/// Area of shares, mm2.
double area_mm2(const ImageF& shares, const PanelOptions& o) { return total_share(shares) * o.pixel_mm * o.pixel_mm; }

/// Share of an area that is covered, percent; `within` is 0 or 1.
double percent_within(const ImageF& shares, const ImageF& within) {
  double part = 0.0;
  for (std::size_t i = 0; i < shares.values().size(); ++i)
    part += static_cast<double>(shares.values()[i]) * static_cast<double>(within.values()[i]);
  return 100.0 * part / total_share(within);
}

/// How far a sum of samples may be off from the area within an outline of this length: each sample that the outline
/// passes is right by chance, with a deviation of at most half its area; 4 of those of their sum.
double sampling_bound(double outline_mm) {
  return 4.0 * 0.5 * std::sqrt(outline_mm * kSamplesPerMm) / (kSamplesPerMm * kSamplesPerMm);
}

/// Bound of an outline that is bent as panels' spots are: no more than 1.6 times that of the circle.
double spot_bound(double area_mm2) { return sampling_bound(1.6 * std::sqrt(4.0 * std::numbers::pi * area_mm2)); }

TEST(Panel, RustCoversThePercentAskedForAtTheEnd) {
  for (const RustPattern pattern : {RustPattern::Spot, RustPattern::General, RustPattern::Pinpoint}) {
    for (const double asked : {0.01, 0.03, 0.1, 1.0, 8.0, 33.0}) {
      PanelOptions o = small_panel();
      o.pattern = pattern;
      o.rust = asked;
      o.seed = static_cast<std::int64_t>(100.0 * asked) + static_cast<int>(pattern);
      const Panel panel = make_panel(o);
      const PanelFrame& last = panel.frames.back();
      // Radii are scaled until the area is within 1e-4; where that is less, samples change some at a time.
      const double samples = 100.0 * 4.0 / (o.test_area_mm2() * kSamplesPerMm * kSamplesPerMm);
      EXPECT_NEAR(percent_within(last.rust, panel.test_area), asked, 1e-4 * asked + samples);
      EXPECT_NEAR(last.figures.rust_test_percent, percent_within(last.rust, panel.test_area), 1e-5 * asked);
      EXPECT_NEAR(last.figures.rust_percent, 100.0 * area_mm2(last.rust, o) / (o.width_mm() * o.height_mm()),
                  1e-5 * asked);
      EXPECT_EQ(total_share(panel.frames.front().rust), 0.0);
    }
  }
  const Panel clean = make_panel({.width = 64, .height = 64, .num_frames = 2, .edge_mm = 0.0, .rust = 0.0});
  EXPECT_TRUE(clean.spots.empty());
  EXPECT_EQ(clean.frames.back().figures.rust_percent, 0.0);
  const Panel narrow = make_panel({.num_frames = 2, .edge_mm = 19.5, .rust = 5.0});  // A hundredth of the panel.
  EXPECT_NEAR(narrow.frames.back().figures.rust_test_percent, 5.0, 5e-4 + 100.0 * 4.0 / (21.0 * 6400.0));
}

TEST(Panel, CoverageIsTheClosedFormOfASpotAndGrowsAsItSays) {
  int num_checked = 0;
  for (std::int64_t seed = 1; seed <= 40; ++seed) {
    PanelOptions o = small_panel();
    o.pattern = RustPattern::Spot;
    o.rust = 0.5;
    o.spot_mm = 1.6;
    o.seed = seed;
    const Panel panel = make_panel(o);
    ASSERT_EQ(panel.spots.size(), 1U);
    const PanelSpot& spot = panel.spots.front();
    const double reach = std::sqrt(spot.area_mm2 / std::numbers::pi) * 1.5;
    if (std::min({spot.x_mm, spot.y_mm, o.width_mm() - spot.x_mm, o.height_mm() - spot.y_mm}) < reach) continue;
    ++num_checked;
    for (const PanelFrame& frame : panel.frames) {
      const double late = std::max(0.0, frame.figures.hours - spot.start_h) / (o.hours - spot.start_h);
      const double expected = spot.area_mm2 * std::pow(late, 1.2);  // The radius is this share to the power of 0.6.
      EXPECT_NEAR(area_mm2(frame.rust, o), expected, spot_bound(expected)) << seed;
    }
  }
  EXPECT_GT(num_checked, 30);
}

TEST(Panel, WhatHasRustedStaysRustedAndWhatIsStainedIsNotRust) {
  PanelOptions o = small_panel();
  o.num_frames = 6;
  o.rust = 10.0;
  o.scribe = true;
  o.edge_rust = 5.0;
  o.crack_density = 0.1;
  const Panel plain = make_panel(o);
  o.stains = 8.0;
  const Panel stained = make_panel(o);
  for (std::size_t i = 0; i < plain.frames.size(); ++i) {
    const PanelFrame& a = plain.frames[i];
    const PanelFrame& b = stained.frames[i];
    EXPECT_EQ(a.rust, b.rust);
    EXPECT_EQ(a.figures.rusted_test_percent, b.figures.rusted_test_percent);
    EXPECT_TRUE(a.stain.empty());
    if (i == 0) continue;
    for (std::size_t p = 0; p < a.rust.values().size(); ++p) {
      ASSERT_GE(a.rust.values()[p], plain.frames[i - 1].rust.values()[p]);
      ASSERT_GE(a.scribe.values()[p], plain.frames[i - 1].scribe.values()[p]);
      ASSERT_GE(a.cracks.values()[p], plain.frames[i - 1].cracks.values()[p]);
    }
  }
  // Whole pixels are stained or not; at one size several may become so.
  EXPECT_NEAR(stained.frames.back().figures.stain_test_percent, 8.0, 1e-4 * 8.0 + 4.0 * 100.0 / (220.0 * 160.0));
  EXPECT_NE(plain.frames.back().photo, stained.frames.back().photo);
}

TEST(Panel, EdgeRustLiesBesideTheTestArea) {
  PanelOptions o = small_panel();
  o.rust = 0.0;
  o.edge_rust = 12.0;
  const Panel panel = make_panel(o);
  const PanelFigures& last = panel.frames.back().figures;
  EXPECT_EQ(last.rust_test_percent, 0.0);
  const double beside_mm2 = o.width_mm() * o.height_mm() - o.test_area_mm2();
  EXPECT_NEAR(area_mm2(panel.frames.back().rust, o), 0.12 * beside_mm2, 2e-4 * 0.12 * beside_mm2);
  EXPECT_TRUE(std::all_of(panel.spots.begin(), panel.spots.end(), [](const PanelSpot& s) { return s.is_edge; }));
}

TEST(Panel, CracksHaveTheLengthAndTheWidthAskedFor) {
  PanelOptions o = small_panel();
  o.rust = 0.0;
  for (const double density : {0.01, 0.2}) {
    o.crack_density = density;
    o.crack_width_mm = 0.25;
    const Panel panel = make_panel(o);
    EXPECT_NEAR(panel.frames.back().figures.crack_mm_per_mm2, density, 1e-9);
    double length = 0.0, weighted = 0.0, expected = 0.0, outline = 0.0;
    for (const PanelCrack& crack : panel.cracks) {
      double steps = 0.0;
      for (std::size_t i = 1; i < crack.points_mm.size(); ++i)
        steps += (crack.points_mm[i] - crack.points_mm[i - 1]).norm();
      EXPECT_NEAR(crack.length_mm, steps, 1e-9);
      length += steps;
      weighted += steps * crack.width_mm;
      // A stroke with round ends: what bends add outside they take inside, but for the third power of an angle.
      expected += steps * crack.width_mm + 0.25 * std::numbers::pi * crack.width_mm * crack.width_mm;
      outline += 2.0 * steps + std::numbers::pi * crack.width_mm;
    }
    if (panel.cracks.size() == 1) {
      EXPECT_NEAR(weighted / length, 0.25, 1e-9);
      EXPECT_NEAR(area_mm2(panel.frames.back().cracks, o), expected, sampling_bound(outline));
    } else {
      EXPECT_LE(area_mm2(panel.frames.back().cracks, o), expected + sampling_bound(outline));  // Some cross each other.
    }
    EXPECT_EQ(total_share(panel.frames.front().cracks), 0.0);
  }
}

TEST(Panel, CreepHasItsMeanOnEachSideOfTheScribe) {
  PanelOptions o = small_panel();
  o.rust = 0.0;
  o.scribe = true;
  o.creep_mm = 1.5;
  const Panel panel = make_panel(o);
  const PanelScribe& scribe = panel.scribes.at(0);
  const double length = (scribe.to_mm - scribe.from_mm).norm();
  EXPECT_NEAR(length, 0.9 * 16.0, 1e-9);
  EXPECT_NEAR(scribe.step_mm * static_cast<double>(scribe.left_mm.size() - 1), length, 1e-9);
  for (const PanelFrame& frame : panel.frames) {
    const double grown = std::pow(frame.figures.hours / o.hours, 0.6);
    EXPECT_NEAR(frame.figures.creep_left_mm, 1.5 * grown, 1e-9);
    EXPECT_NEAR(frame.figures.creep_right_mm, 1.5 * grown, 1e-9);
    const double wide = scribe.width_mm + 2.0 * 1.5 * grown;
    // The profiles wind: no more than 4 times as long as the scribe.
    EXPECT_NEAR(area_mm2(frame.scribe, o), length * wide, sampling_bound(8.0 * length + 2.0 * wide));
    EXPECT_GE(frame.figures.creep_max_mm, 1.5 * grown);
  }
  const double most = *std::max_element(scribe.right_mm.begin(), scribe.right_mm.end());
  EXPECT_GE(panel.frames.back().figures.creep_max_mm, most);
  EXPECT_NEAR(panel.frames.back().figures.rusted_percent,
              100.0 * area_mm2(panel.frames.back().scribe, o) / (o.width_mm() * o.height_mm()), 1e-4);
}

TEST(Panel, ScribesThatCrossMeetInTheMiddleAndCreepAlike) {
  PanelOptions o = small_panel();
  o.rust = 0.0;
  o.scribe = true;
  o.cross = true;
  o.creep_mm = 0.5;
  const Panel panel = make_panel(o);
  ASSERT_EQ(panel.scribes.size(), 2U);
  const double length = 0.9 * 16.0, wide = 0.5 + 2.0 * 0.5;
  for (const PanelScribe& scribe : panel.scribes) {
    EXPECT_NEAR((scribe.to_mm - scribe.from_mm).norm(), length, 1e-9);
    EXPECT_NEAR((0.5 * (scribe.to_mm + scribe.from_mm) - Vec2(0.5 * o.width_mm(), 0.5 * o.height_mm())).norm(), 0.0,
                1e-9);
  }
  const PanelFigures& last = panel.frames.back().figures;
  EXPECT_NEAR(last.creep_left_mm, 0.5, 1e-9);
  EXPECT_NEAR(last.creep_right_mm, 0.5, 1e-9);
  // Both cover `wide`, and share a rhombus where they cross at 80 degrees; creep is uneven, so that its size is known
  // to the largest creep.
  const double shared = wide * wide / std::sin(80.0 * std::numbers::pi / 180.0);
  const double most = std::pow(0.5 + 2.0 * last.creep_max_mm, 2.0) / std::sin(80.0 * std::numbers::pi / 180.0);
  EXPECT_NEAR(area_mm2(panel.frames.back().scribe, o), 2.0 * length * wide - shared, most);
}

TEST(Panel, PhotographedPaintHasItsColorAndTheNoiseItsDeviation) {
  PanelOptions o = small_panel();
  o.rust = 0.0;
  o.paint = {45.0, -12.0, -20.0};
  o.color_change = {6.0, 2.0, 5.0};
  const Panel panel = make_panel(o);
  const auto in_test = static_cast<double>(total_share(panel.test_area));
  for (const PanelFrame& frame : panel.frames) {
    std::array<double, 3> mean{};
    for (int y = 0; y < o.height; ++y) {
      for (int x = 0; x < o.width; ++x) {
        for (std::size_t c = 0; c < 3; ++c) {
          const float code = static_cast<float>(frame.photo.at(x, y, static_cast<int>(c))) / 255.0f;
          mean[c] += static_cast<double>(panel.test_area.at(x, y)) * static_cast<double>(linear_from_srgb(code));
        }
      }
    }
    const std::array<double, 3> lab = lab_from_linear(mean[0] / in_test, mean[1] / in_test, mean[2] / in_test);
    // Rounding of 35,200 codes leaves 0.01 of one in their mean, the table of the curve another 0.01, and the blur
    // moves no more over the test area's border; a code is at most 2 of b*.
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(lab[c], frame.figures.paint[c], 0.06);
  }
  o.noise = 0.02;
  const Panel noisy = make_panel(o);
  double squares = 0.0;
  const auto before = panel.frames[2].photo.values(), after = noisy.frames[2].photo.values();
  for (std::size_t i = 0; i < before.size(); ++i) squares += std::pow(1.0 * after[i] - before[i], 2);
  const auto count = static_cast<double>(before.size());
  // Both are rounded: 1/12 each; 4 deviations of a variance's estimate.
  const double variance = std::pow(255.0 * 0.02, 2) + 1.0 / 6.0;
  EXPECT_NEAR(squares / count, variance, 4.0 * variance * std::sqrt(2.0 / count));
}

/// Mean distance from a spot to the nearest other one, over that of places anywhere [Clark and Evans 1954].
double nearest_ratio(const Panel& panel) {
  const PanelOptions& o = panel.options;
  double total = 0.0;
  for (const PanelSpot& a : panel.spots) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const PanelSpot& b : panel.spots) {
      if (&a != &b) nearest = std::min(nearest, std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm));
    }
    total += nearest;
  }
  const auto count = static_cast<double>(panel.spots.size());
  return total / count * 2.0 * std::sqrt(count / (o.width_mm() * o.height_mm()));
}

TEST(Panel, PatternsDifferInHowSpotsLieAndInTheirSizes) {
  PanelOptions o = small_panel();
  o.rust = 8.0;
  o.spot_mm = 0.6;
  o.pattern = RustPattern::General;
  const Panel general = make_panel(o);
  o.pattern = RustPattern::Pinpoint;
  const Panel pinpoint = make_panel(o);
  o.pattern = RustPattern::Spot;
  const Panel heaps = make_panel(o);
  // 1 for places anywhere, with a deviation of 0.26 / 0.5 / sqrt(count), and some more for what lies at the border.
  for (const Panel* panel : {&general, &pinpoint}) {
    const auto count = static_cast<double>(panel->spots.size());
    EXPECT_NEAR(nearest_ratio(*panel), 1.0, 4.0 * 0.52 / std::sqrt(count) + 0.52 / std::sqrt(count));
  }
  EXPECT_LT(nearest_ratio(heaps), 0.6);
  const auto spread = [](const Panel& panel) {
    double mean = 0.0, squares = 0.0;
    for (const PanelSpot& spot : panel.spots) {
      mean += std::log(spot.area_mm2);
      squares += std::pow(std::log(spot.area_mm2), 2);
    }
    const auto count = static_cast<double>(panel.spots.size());
    return std::sqrt(squares / count - std::pow(mean / count, 2));
  };
  EXPECT_GT(spread(general), 2.0 * spread(pinpoint));
}

PanelOptions with_everything() {
  PanelOptions o = small_panel();
  o.rust = 5.0;
  o.edge_rust = 3.0;
  o.stains = 4.0;
  o.scribe = true;
  o.crack_density = 0.05;
  o.noise = 0.01;
  return o;
}

TEST(Panel, SameBytesForAnyNumberOfThreads) {
  RunControl one, three;
  one.num_threads = 1;
  three.num_threads = 3;
  const Panel a = make_panel(with_everything(), one), b = make_panel(with_everything(), three);
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].photo, b.frames[i].photo);
    EXPECT_EQ(a.frames[i].rust, b.frames[i].rust);
    EXPECT_EQ(a.frames[i].scribe, b.frames[i].scribe);
    EXPECT_EQ(a.frames[i].stain, b.frames[i].stain);
    EXPECT_EQ(a.frames[i].cracks, b.frames[i].cracks);
  }
}

TEST(Panel, ProjectFolderHoldsWhatALabWouldHaveAndTheTruth) {
  const testing_support::TempFolder temp;
  const PanelOptions o = with_everything();
  run_job(plan_panel(o, temp / "panel"), {}, {});
  const Json capture = load_json(temp / "panel/capture.json");
  EXPECT_EQ(capture.at("time_unit"), "h");
  EXPECT_EQ(capture.at("texel_size_mm"), 0.1);
  EXPECT_EQ(capture.at("frames").at("interval"), 160.0);
  EXPECT_EQ(probe_image(temp / "panel/frames/0003.png").width, 300);
  const Json truth = load_json(temp / "panel/truth/truth.json");
  const Panel panel = make_panel(o);
  ASSERT_EQ(truth.at("frames").size(), 4U);
  const Json& last = truth.at("frames").at(3);
  const PanelFrame& frame = panel.frames.back();
  EXPECT_EQ(last.at("time"), 480.0);
  EXPECT_EQ(last.at("rust_test_percent"), frame.figures.rust_test_percent);
  EXPECT_EQ(last.at("creep_max_mm"), frame.figures.creep_max_mm);
  EXPECT_EQ(truth.at("spots").size(), panel.spots.size());
  EXPECT_EQ(truth.at("cracks").size(), panel.cracks.size());
  const auto map = [&](const char* name) { return read_gray(temp / "panel/truth" / last.at(name).get<std::string>()); };
  EXPECT_EQ(map("rust"), frame.rust);
  EXPECT_EQ(map("scribe"), frame.scribe);
  EXPECT_EQ(map("stain"), frame.stain);
  EXPECT_EQ(map("cracks"), frame.cracks);
  EXPECT_EQ(read_gray(temp / "panel/truth/test_area.exr"), panel.test_area);
}

TEST(Panel, OptionsThatDoNotFitAreRefusedInOneLine) {
  const auto refusal = [](const PanelOptions& o) -> std::string {
    try {
      (void)make_panel(o);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal({.width = 100, .height = 100}),
            "edge: 10 mm leave no test area on a panel of 10 x 10 mm; use less");
  EXPECT_NE(refusal({.paint = {50.0, 90.0, -100.0}}).find("outside of sRGB"), std::string::npos);
  EXPECT_NE(refusal({.edge_mm = 0.0, .edge_rust = 1.0}).find("edge_rust"), std::string::npos);
  EXPECT_EQ(refusal({.cross = true}), "cross: needs a scribe");
  EXPECT_NE(refusal({.scribe = true, .creep_mm = 40.0}).find("creep"), std::string::npos);
  for (const PanelOptions& o : {PanelOptions{.pixel_mm = 0.0}, PanelOptions{.rust = 61.0}, PanelOptions{.rust = -1.0},
                                PanelOptions{.blur_px = std::nan("")}, PanelOptions{.spot_mm = 0.0}}) {
    const std::string text = refusal(o);
    EXPECT_NE(text, "accepted");
    EXPECT_EQ(text.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace patinate::datasets
