#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "analysis/grading/gloss_units.h"
#include "analysis/grading/grade_limits.h"
#include "analysis/grading/grade_times.h"
#include "analysis/grading/panel_mask.h"
#include "analysis/grading/region_figures.h"
#include "analysis/grading/rust_map.h"
#include "libcommon/core/random.h"
#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

const GradeRules kRules = standard_grade_rules();

const GradeScale& scale(const std::string& name) {
  return *std::find_if(kRules.scales.begin(), kRules.scales.end(), [&](const GradeScale& s) { return s.name == name; });
}

std::string grade(const std::string& name, double value) {
  return scale(name).grades[grade_index(scale(name), value)].name;
}

TEST(GradeRules, HaveTheLimitsOfTheStandards) {
  EXPECT_EQ(grade("ri", 0.0), "0");
  EXPECT_EQ(grade("ri", 0.05), "1");
  EXPECT_EQ(grade("ri", 0.051), "2");
  EXPECT_EQ(grade("ri", 7.9), "4");
  EXPECT_EQ(grade("ri", 99.0), "5");
  EXPECT_EQ(grade("d610", 0.01), "10");
  EXPECT_EQ(grade("d610", 0.011), "9");
  EXPECT_EQ(grade("d610", 0.3), "7");
  EXPECT_EQ(grade("d610", 51.0), "0");
  EXPECT_EQ(grade("creep", 2.5), "6");
  EXPECT_EQ(grade("blister_size", 0.4), "3");
  EXPECT_EQ(grade("d714_size", 0.4), "6");
  EXPECT_EQ(grade("d714_frequency", 4.0), "2");
  EXPECT_EQ(grade("flaking", 0.3), "2");
  EXPECT_EQ(grade("flake_size", 12.0), "4");
}

/// Gray paint with a disk of rust and a pale stain, seen through a camera.
struct DrawnPanel {
  int size = 160;
  double radius = 14.3, stain = 12.0;
  double blur_px = 1.0, noise = 0.004, exposure = 1.0;
  std::uint64_t seed = 1;

  [[nodiscard]] ImageF image(bool is_rusted) const {
    constexpr std::array<double, 3> kPaint{0.55, 0.56, 0.54}, kRust{0.20, 0.075, 0.03}, kStain{0.50, 0.44, 0.33};
    ImageF out(size, size, 3);
    RandomStream random(seed, 0, 0);
    const auto normal = [&] {
      return std::sqrt(-2.0 * std::log(1.0 - random.uniform())) * std::cos(2 * std::numbers::pi * random.uniform());
    };
    // The edge of a disk that is large beside the blur is an error function.
    const auto inside = [&](double distance) { return 0.5 * std::erfc(distance / (std::numbers::sqrt2 * blur_px)); };
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double rust = is_rusted ? inside(std::hypot(x - 50.2, y - 60.7) - radius) : 0.0;
        const double stained = is_rusted ? inside(std::hypot(x - 110.0, y - 100.0) - stain) : 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
          double v = kPaint[c] + stained * (kStain[c] - kPaint[c]);
          v += rust * (kRust[c] - v);
          out.at(x, y, static_cast<int>(c)) = static_cast<float>(exposure * v + noise * normal());
        }
      }
    }
    return out;
  }
};

RustMap map_of(const std::vector<ImageF>& frames, bool has_unexposed = true) {
  const ImageU8 mask(frames.front().width(), frames.front().height(), 1, 255);
  return RustMap({.num_frames = static_cast<int>(frames.size()),
                  .color = [&](int t) { return frames[static_cast<std::size_t>(t)]; },
                  .mask = mask,
                  .unexposed = has_unexposed ? std::optional(0) : std::nullopt},
                 kRules.rust);
}

TEST(RustMap, CountsPartsOfPixelsAndNoStains) {
  for (const double radius : {3.0, 6.4, 14.3}) {
    for (const double exposure : {1.0, 0.8}) {
      DrawnPanel before, after;
      after.radius = radius;
      after.exposure = exposure;
      after.seed = 2;
      const RustMap map = map_of({before.image(false), after.image(true)});
      EXPECT_TRUE(map.at(0).spots.empty());
      const RustFrame frame = map.at(1);
      ASSERT_EQ(frame.spots.size(), 1u) << radius << " " << exposure;
      const double truth = std::numbers::pi * radius * radius;
      // A quarter of a pixel along the edge is what the interval allows.
      EXPECT_NEAR(frame.spots[0].area_px, truth, 0.25 * 2 * std::numbers::pi * radius) << radius << " " << exposure;
      EXPECT_NEAR(frame.spots[0].x, 50.2, 0.5);
      EXPECT_NEAR(frame.spots[0].y, 60.7, 0.5);
    }
  }
}

TEST(RustMap, FindsNoneOnACleanSurfaceWhoseLightDrifts) {
  DrawnPanel clean;
  std::vector<ImageF> frames;
  for (int t = 0; t < 5; ++t) {
    clean.exposure = 1.0 - 0.08 * t;
    clean.seed = static_cast<std::uint64_t>(t);
    frames.push_back(clean.image(false));
  }
  const RustMap map = map_of(frames);
  for (int t = 0; t < 5; ++t) EXPECT_TRUE(map.at(t).spots.empty()) << t;
  EXPECT_FALSE(map.rust_color());
}

/// A bare steel plate as it is photographed: mill scale, and squares of orange, brown and black-brown rust.
ImageF bare_steel(bool is_rusted, std::uint64_t seed) {
  constexpr std::array<double, 3> kScale{0.058, 0.063, 0.075};  // L* 30, blue-gray.
  constexpr std::array<std::array<double, 3>, 3> kRust{
      {{0.22, 0.07, 0.017}, {0.085, 0.032, 0.014}, {0.04, 0.02, 0.01}}};
  ImageF out(240, 120, 3);
  RandomStream random(seed, 0, 0);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const int column = x / 80;
      const bool is_inside = is_rusted && x % 80 >= 20 && x % 80 < 60 && y >= 40 && y < 80;
      for (std::size_t c = 0; c < 3; ++c) {
        const double v = is_inside ? kRust[static_cast<std::size_t>(column)][c] : kScale[c];
        out.at(x, y, static_cast<int>(c)) = static_cast<float>(v + 0.004 * (random.uniform() - 0.5));
      }
    }
  }
  return out;
}

TEST(RustMap, RustOfAnyBrightnessCountsOnBareSteel) {
  const RustFrame frame = map_of({bare_steel(false, 1), bare_steel(true, 2)}).at(1);
  ASSERT_EQ(frame.spots.size(), 3u);
  // Half a pixel along the edges: these have no blur, which the sum over the edge expects.
  for (const RustSpot& spot : frame.spots) EXPECT_NEAR(spot.area_px, 1600.0, 0.5 * 160.0) << spot.x;
}

TEST(RustMap, ASurfaceThatHasRustedAllOverIsNoDriftOfLight) {
  const ImageF before = bare_steel(false, 1);
  ImageF film = before;
  constexpr std::array<float, 3> kFilm{0.075f, 0.046f, 0.028f};  // Brown, hardly darker than the scale.
  for (int y = 0; y < film.height(); ++y) {
    for (int x = 0; x < film.width(); ++x) std::copy(kFilm.begin(), kFilm.end(), film.pixel(x, y).begin());
  }
  const RustFrame frame = map_of({before, film}).at(1);
  double sum = 0.0;
  for (std::size_t i = 0; i < frame.labels.size(); ++i) sum += static_cast<double>(frame.coverage.data()[i]);
  EXPECT_GT(sum, 0.9 * 240 * 120);
}

TEST(RustMap, DarkLinesAreNoRustEvenWhereTheyTouchIt) {
  const DrawnPanel before, after{.seed = 2};
  ImageF now = after.image(true);
  // Gray cracks of 3 px across the whole picture, through the spot.
  for (int k = 0; k < now.width(); ++k) {
    for (int d = -1; d <= 1; ++d) {
      for (int c = 0; c < 3; ++c) now.at(k, now.height() / 2 + d, c) = now.at(now.width() / 2 + d, k, c) = 0.09f;
    }
  }
  const RustFrame plain = map_of({before.image(false), after.image(true)}).at(1);
  const RustFrame cracked = map_of({before.image(false), now}).at(1);
  const auto area = [](const RustFrame& frame) {
    double sum = 0.0;
    for (const RustSpot& spot : frame.spots) sum += spot.area_px;
    return sum;
  };
  // The cracks take 171 px of the spot's 642, and nothing outside of it is added.
  EXPECT_LT(area(cracked), area(plain));
  EXPECT_GT(area(cracked), area(plain) - 6 * 2 * after.radius - 9);
}

TEST(RustMap, OnePhotographTellsItsRust) {
  const DrawnPanel panel;
  const RustMap map = map_of({panel.image(true)}, false);
  ASSERT_EQ(map.at(0).spots.size(), 1u);
  EXPECT_NEAR(map.at(0).spots[0].area_px, std::numbers::pi * 14.3 * 14.3, 0.25 * 2 * std::numbers::pi * 14.3);
}

TEST(RustMap, AFlashThatGoesIsNoRust) {
  DrawnPanel panel;
  // Brown for one photograph of five: something lay on it.
  std::vector<ImageF> frames;
  for (int t = 0; t < 5; ++t) frames.push_back(panel.image(t == 2));
  frames.back() = panel.image(false);
  for (int t = 0; t < 5; ++t) EXPECT_TRUE(map_of(frames).at(t).spots.empty());
}

TEST(RegionFigures, SayWhereRustLies) {
  const auto letter = [](const std::vector<std::array<double, 3>>& disks) {
    ImageU8 region(200, 200, 1, 255);
    RustFrame rust{ImageF(200, 200), std::vector<int>(40000, -1), {}};
    for (std::size_t k = 0; k < disks.size(); ++k) {
      const auto [x0, y0, r] = disks[k];
      double area = 0;
      for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 200; ++x) {
          if (std::hypot(x - x0, y - y0) > r) continue;
          rust.coverage.at(x, y) = 1.0f;
          rust.labels[static_cast<std::size_t>(y * 200 + x)] = static_cast<int>(k);
          ++area;
        }
      }
      rust.spots.push_back({x0, y0, area, 6.3 * r, true});
    }
    RegionFigures figures;
    add_rust_figures(rust, region, 0.2, kRules.rust, figures);
    EXPECT_EQ(figures.num_spots, static_cast<int>(disks.size()));
    return figures.distribution;
  };
  std::vector<std::array<double, 3>> pinpoints, large;
  for (int k = 0; k < 36; ++k) pinpoints.push_back({15.0 + 30 * (k % 6), 15.0 + 30 * (k / 6), 2.0});
  for (int k = 0; k < 16; ++k) large.push_back({25.0 + 50 * (k % 4), 25.0 + 50 * (k / 4), 9.0});
  EXPECT_EQ(letter(pinpoints), "P");
  EXPECT_EQ(letter(large), "G");
  EXPECT_EQ(letter({{60, 60, 15}, {75, 80, 14}}), "S");
  std::vector<std::array<double, 3>> both = pinpoints;
  both.push_back({100, 100, 8});
  EXPECT_EQ(letter(both), "H");
}

TEST(RegionFigures, CreepIsTheMeanOfBothSidesWithoutTheScratch) {
  const double pixel_mm = 0.1;
  ImageF rust(400, 300);
  // A scratch of 1 mm at x = 20 mm from y = 5 to 25 mm; rust reaches 2 mm to its left and 3 mm to its right.
  for (int y = 50; y < 250; ++y) {
    for (int x = 175; x < 235; ++x) rust.at(x, y) = 1.0f;
  }
  RegionFigures figures;
  add_creep_figures(rust, ImageU8(400, 300, 1, 255), pixel_mm, {{20, 5, 20, 25, 1.0}}, figures);
  EXPECT_NEAR(figures.figure("creep_mm")->value, 2.5, pixel_mm);
  EXPECT_NEAR(figures.figure("creep_max_mm")->value, 3.0, pixel_mm);
}

TEST(RegionFigures, ColorsAreThoseOfTheCoating) {
  const std::array<double, 3> before = linear_from_lab({70, 0, 2}), after = linear_from_lab({73, 1, 8});
  ImageF a(20, 20, 3), b(20, 20, 3), rust(20, 20);
  for (int i = 0; i < 400; ++i) {
    for (int c = 0; c < 3; ++c) {
      a.data()[3 * i + c] = static_cast<float>(before[static_cast<std::size_t>(c)]);
      b.data()[3 * i + c] = i < 100 ? 0.02f : static_cast<float>(after[static_cast<std::size_t>(c)]);
    }
    rust.data()[i] = i < 100 ? 1.0f : 0.0f;
  }
  RegionFigures figures;
  add_color_figures(a, b, rust, {}, ImageU8(20, 20, 1, 255), figures);
  EXPECT_NEAR(figures.figure("delta_l")->value, 3.0, 0.01);
  EXPECT_NEAR(figures.figure("delta_a")->value, 1.0, 0.01);
  EXPECT_NEAR(figures.figure("delta_b")->value, 6.0, 0.01);
  EXPECT_NEAR(figures.figure("delta_e")->value, std::sqrt(46.0), 0.01);
  EXPECT_NEAR(figures.figure("ciede2000")->value, ciede2000({70, 0, 2}, {73, 1, 8}), 0.01);
}

TEST(RegionFigures, ColorsLieBetweenTheCodesOfAPhotograph) {
  // Codes of 8 bits with noise of one code; the change is 0.4 of a code.
  const auto photograph = [](double value, std::uint64_t seed) {
    RandomStream random(seed, 0, 1);
    ImageF image(80, 60, 3);
    for (float& v : image.values()) v = static_cast<float>(std::round(value + random.normal()) / 255.0);
    return image;
  };
  const ImageF a = photograph(150.0, 1), b = photograph(150.4, 2), none(80, 60);
  RegionFigures figures;
  add_color_figures(a, b, none, {}, ImageU8(80, 60, 1, 255), figures);
  const GradedFigure found = *figures.figure("delta_l");
  const auto lightness = [](double code) { return lab_from_linear(code / 255, code / 255, code / 255)[0]; };
  const double truth = lightness(150.4) - lightness(150.0);
  EXPECT_NEAR(found.value, truth, 0.25 * truth);
  EXPECT_LT(found.low, truth);
  EXPECT_GT(found.high, truth);
}

TEST(RegionFigures, AnIntervalIsThatOfTheMeanOfPlaces) {
  // 16 places that change by -0.02 and 0.02 in turn: Student's 95th percentile of 15 degrees is 1.753.
  ImageF a(80, 80, 3, 0.5f), b = a;
  const ImageF none(80, 80);
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 80; ++x) {
      for (int c = 0; c < 3; ++c) b.at(x, y, c) += (x / 20 + y / 20) % 2 == 0 ? -0.02f : 0.02f;
    }
  }
  RegionFigures figures;
  add_color_figures(a, b, none, {}, ImageU8(80, 80, 1, 255), figures);
  const GradedFigure found = *figures.figure("delta_l");
  const auto lightness = [](double v) { return lab_from_linear(v, v, v)[0]; };
  const double deviation = 0.5 * (lightness(0.52) - lightness(0.48)) * std::sqrt(16.0 / 15.0);
  EXPECT_NEAR(found.high - found.low, 2 * 1.753 * deviation / 4, 0.01 * deviation);
}

TEST(RegionFigures, CracksAreNeitherColorNorShorterThanTheirLine) {
  // Twenty dark lines of 2 px and 100 px each: 2,000 px of 120 x 120, which they cover by a quarter and more.
  ImageF a(120, 120, 3, 0.5f), b(120, 120, 3, 0.55f);
  ImageU8 cracks(120, 120);
  for (int k = 0; k < 20; ++k) {
    for (int x = 10; x < 110; ++x) {
      for (int y = 6 * k + 1; y < 6 * k + 3; ++y) {
        cracks.at(x, y) = 255;
        for (int c = 0; c < 3; ++c) b.at(x, y, c) = 0.02f;
      }
    }
  }
  RegionFigures figures;
  add_color_figures(a, b, ImageF(120, 120), cracks, ImageU8(120, 120, 1, 255), figures);
  const auto lightness = [](double v) { return lab_from_linear(v, v, v)[0]; };
  EXPECT_NEAR(figures.figure("delta_l")->value, lightness(0.55) - lightness(0.5), 1e-3);
  add_crack_figures(cracks, ImageU8(120, 120, 1, 255), 0.1, figures);
  const GradedFigure length = *figures.figure("crack_mm_per_mm2");
  const double truth = 2000 * 0.1 / (14400 * 0.01);
  EXPECT_LT(length.low, truth);
  EXPECT_GT(length.high, truth);
}

TEST(GlossUnits, BlackGlassHasAHundredAndRoughSurfacesHaveLess) {
  const double f0 = std::pow(0.567 / 2.567, 2);
  for (const auto& [angle, window_deg] : std::vector<std::pair<double, double>>{{20, 1.8}, {60, 4.4}, {85, 4.0}}) {
    // GGX has a share of 1 / (1 + (h / alpha)^2) beyond a half angle of h, here half of half the window, alpha =
    // 0.0025.
    const double h = 0.25 * window_deg * std::numbers::pi / 180.0;
    EXPECT_GT(gloss_units(angle, f0, 0.05), 100.0 * (1.0 - 1.0 / (1.0 + std::pow(h / 0.0025, 2)))) << angle;
    EXPECT_LT(gloss_units(angle, f0, 0.05), 100.5) << angle;
    EXPECT_GT(gloss_units(angle, f0, 0.2), gloss_units(angle, f0, 0.4)) << angle;
  }
  EXPECT_LT(gloss_units(60, 0.04, 0.6), 10.0);
  EXPECT_THROW((void)gloss_units(45, 0.04, 0.3), InvalidInput);
}

TEST(GradeTimes, LieBetweenPhotographs) {
  const std::vector<double> times{0, 100, 200, 300};
  const std::vector<std::optional<GradedFigure>> figures{GradedFigure{0, 0, 0.005}, GradedFigure{0.02, 0.015, 0.025},
                                                         GradedFigure{0.1, 0.08, 0.12}, GradedFigure{0.8, 0.7, 0.9}};
  const std::vector<GradeTime> all = grade_times(scale("ri"), times, figures, 0.001, times.back());
  ASSERT_EQ(all.size(), 5u);
  // Ri 1 begins above nothing: on the line from 0 to 0.02, where it is 0.005, which the first photograph may hide.
  EXPECT_NEAR(*all[0].time, 25.0, 1e-9);
  // Ri 2 begins above 0.05 %: between 0.02 and 0.1.
  EXPECT_EQ(all[1].state, Reached::Reached);
  EXPECT_NEAR(*all[1].time, 137.5, 1e-9);
  EXPECT_EQ(all[1].earliest, 100.0);
  EXPECT_EQ(all[1].latest, 200.0);
  EXPECT_EQ(all[3].state, Reached::NotReached);
  EXPECT_FALSE(all[3].earliest);
  EXPECT_NEAR(figure_at(times, figures, 250)->value, 0.45, 1e-12);
  EXPECT_FALSE(figure_at(times, figures, 301));
  // Where less than 0.03 % cannot be seen, 0.02 % has no grade yet.
  const std::vector<GradeTime> coarse = grade_times(scale("ri"), times, figures, 0.03, times.back());
  EXPECT_NEAR(*coarse[0].time, 112.5, 1e-9);
}

TEST(GradeLimits, AreReadAndSayWhichLineIsWrong) {
  const TempFolder folder;
  const auto read = [&](const std::string& text) {
    std::ofstream(folder / "limits.txt") << text;
    return read_grade_limits(folder / "limits.txt", kRules, TimeUnit::Hours);
  };
  const std::vector<GradeLimit> limits =
      read("# coating A\nRi <= 2 at 20 d\n\ngloss retention >= 50 % at 1000 h  # 60 deg\n");
  ASSERT_EQ(limits.size(), 2u);
  EXPECT_EQ(limits[0].name, "ri");
  EXPECT_EQ(limits[0].time, 480.0);
  EXPECT_EQ(limits[1].name, "gloss_60");
  EXPECT_TRUE(limits[1].is_retention);
  EXPECT_FALSE(limits[1].is_at_most);
  for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
           {"rl <= 2 at 480 h", "line 1: found `rl <= 2 at 480 h`; `rl` is no scale or figure; did you mean `ri`?"},
           {"\nri = 2 at 480 h", "line 2: found `ri = 2 at 480 h`; expected NAME"},
           {"ri <= 2", "expected NAME"},
           {"", "holds no limit"}}) {
    const std::string said = error_of([&] { (void)read(text); });
    EXPECT_TRUE(has(said, expected)) << said;
  }
}

TEST(GradeLimits, PassFailOrNotDecided) {
  GradedSurface surface{.times = {0, 100}, .unexposed_time = 0.0};
  GradedRegion& region = surface.regions.emplace_back();
  region.name = "sample";
  region.times.resize(2);
  region.times[0].figures[0] = GradedFigure{0, 0, 0};
  region.times[1].figures[0] = GradedFigure{0.4, 0.35, 0.55};  // Ri 2, perhaps 3.
  const auto state = [&](double most) {
    const GradeLimit limit{.text = "", .name = "ri", .value = most, .time = 100};
    return check_limits({limit}, surface, kRules).at(0).state;
  };
  EXPECT_EQ(state(3), LimitState::Pass);
  EXPECT_EQ(state(2), LimitState::Undecided);
  EXPECT_EQ(state(1), LimitState::Fail);
}

TEST(PolygonMask, HasTheAreaOfThePolygon) {
  const ImageU8 mask = polygon_mask(400, 300, 0.1, {5, 5, 35, 5, 35, 20});
  const auto count = std::count(mask.values().begin(), mask.values().end(), 255);
  EXPECT_NEAR(static_cast<double>(count) * 0.01, 225.0, 0.1 * (30 + 15 + 33.5) / 2 + 1);
  EXPECT_THROW((void)polygon_mask(400, 300, 0.1, {5, 5, 350, 5, 35, 20}), InvalidInput);
  EXPECT_THROW((void)polygon_mask(400, 300, 0.1, {5, 5, 35, 5}), InvalidInput);
}

}  // namespace
}  // namespace patinate::analysis
