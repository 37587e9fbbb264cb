#include "analysis/fit/fit_objective.h"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/compare/sections.h"
#include "analysis/fit/fit_parameter.h"
#include "tests/analysis/fit/fit_model.h"
#include "tests/support/errors.h"
#include "tests/support/temp_folder.h"

namespace patinate::analysis {
namespace {

using namespace testing_support;
using Figures = std::vector<std::pair<FitFigure, std::string>>;

std::vector<FitTerm> all_terms() {
  std::vector<FitTerm> terms;
  for (std::size_t i = 0; i < kFitFigureNames.size(); ++i) terms.push_back({.figure = static_cast<FitFigure>(i)});
  return terms;
}

SurfaceOutline outline_of(const AgedSurface& frames) {
  return {.name = frames.name,
          .width = frames.mask.width(),
          .height = frames.mask.height(),
          .time_unit = frames.time_unit,
          .times = frames.times,
          .control_names = {"x"}};
}

/// Colors are halves on both sides; what is computed of them in floats has 24 bits, over sums of thousands.
constexpr double kRounding = 1e-5;

TEST(FitObjective, IsZeroForTheSameSurfaceInEveryFigure) {
  const TempFolder folder;
  const AgedSurface frames = green_plate(kGreenTruth);
  write_surface(folder.path() / "a", frames, "0123456789abcdef");
  const FitObjective objective(open_series(folder.path() / "a").series, outline_of(frames), all_terms(), {});
  const ObjectiveValue value = objective(frames);
  ASSERT_EQ(value.figures.size(), kFitFigureNames.size());
  for (std::size_t i = 0; i < value.figures.size(); ++i) EXPECT_EQ(value.figures[i].value(), 0.0) << kFitFigureNames[i];
}

TEST(FitObjective, EqualsTheFiguresOfAComparison) {
  const TempFolder folder;
  const AgedSurface a = green_plate(kGreenTruth), b = green_plate({0.15, 0.5, 0.0});
  write_surface(folder.path() / "a", a, "0123456789abcdef");
  write_surface(folder.path() / "b", b, "0123456789abcdee");
  const ObjectiveOptions options;
  const FitObjective objective(open_series(folder.path() / "a").series, outline_of(b), all_terms(), options);
  const ObjectiveValue value = objective(b);
  CompareOptions compare = compare_options(options);
  compare.num_resamples = 0;
  compare.places = Places::Equal;  // Places as ciede2000 of a fit states.
  const ComparedPair pair =
      load_pair(open_series(folder.path() / "a").series, open_series(folder.path() / "b").series, compare);
  std::vector<Figure> figures;
  for (const Section& s : {colors_section(pair, compare), controls_section(pair, compare),
                           places_section(pair, compare), structure_section(pair, compare)})
    figures.insert(figures.end(), s.figures.begin(), s.figures.end());
  const auto compared = [&](const std::string& name) {
    for (const Figure& f : figures) {
      if (f.name == name) return f.value.value();
    }
    ADD_FAILURE() << name;
    return 0.0;
  };
  const auto fitted = [&](FitFigure figure) { return value.figures[static_cast<std::size_t>(figure)].value(); };
  const double span = 8.0;
  EXPECT_NEAR(fitted(FitFigure::ColorDistribution), compared("color_distribution"), kRounding);
  EXPECT_NEAR(fitted(FitFigure::Covered), 100.0 * compared("covered_distance"),
              0.5);  // Texels at the border of being visible: half a per cent of them.
  EXPECT_NEAR(fitted(FitFigure::Onset), 100.0 * compared("onset_distance") / span, 0.2);
  EXPECT_NEAR(fitted(FitFigure::Saturation), 100.0 * compared("saturation_distance") / span, 0.2);
  EXPECT_NEAR(fitted(FitFigure::ColorByControl), compared("color_by_x"), kRounding);
  EXPECT_NEAR(fitted(FitFigure::RateByControl), span * compared("rate_by_x"), kRounding);
  EXPECT_NEAR(fitted(FitFigure::Ciede2000), compared("ciede2000_mean"), kRounding);
  EXPECT_NEAR(fitted(FitFigure::Contrast), compared("contrast_distance"), kRounding);
}

TEST(FitObjective, ContrastTellsAPatternFromItsScrambledPlacesThatHaveTheSameColors) {
  const TempFolder folder;
  AgedSurface smooth = green_plate(kGreenTruth);
  smooth.controls.clear();
  AgedSurface scrambled = smooth;
  for (ImageF& color : scrambled.colors) {
    const ImageF from = color;
    for (int y = 0; y < color.height(); ++y) {
      for (int x = 0; x < color.width(); ++x) {  // 7 and 24 share no factor: every column once.
        for (int c = 0; c < 3; ++c) color.at(x, y, c) = from.at((7 * x + 5 * y) % color.width(), y, c);
      }
    }
  }
  write_surface(folder.path() / "smooth", smooth, "0123456789abcdef");
  write_surface(folder.path() / "scrambled", scrambled, "0123456789abcdee");
  SurfaceOutline outline = outline_of(scrambled);
  outline.control_names.clear();
  const FitObjective objective(open_series(folder.path() / "smooth").series, outline,
                               {{FitFigure::ColorDistribution}, {FitFigure::Contrast}}, {});
  const ObjectiveValue v = objective(scrambled);
  EXPECT_NEAR(v.figures[0].value(), 0.0, kRounding);
  AgedSurface flat = smooth;
  for (ImageF& color : flat.colors) color = ImageF(color.width(), color.height(), 3, 0.2F);
  const double all_of_it =
      FitObjective(open_series(folder.path() / "scrambled").series, outline, {{FitFigure::Contrast}}, {})(flat)
          .objective.value();
  // A tile of 8 of 24 columns has a third of the ramp, so that a third of the scrambled one's contrast is left of it.
  EXPECT_GT(v.figures[1].value(), 0.5 * all_of_it);
}

/// Gray paint; at the end a rectangle of it has rusted.
AgedSurface rusting_paint(int rust_width, int rust_height) {
  AgedSurface out;
  out.name = "paint";
  out.time_unit = TimeUnit::Hours;
  out.times = {0.0, 480.0};
  out.mask = ImageU8(120, 80, 1, 255);
  for (const bool is_rusted : {false, true}) {
    ImageF& color = out.colors.emplace_back(120, 80, 3, 0.5F);
    for (int y = 20; is_rusted && y < 20 + rust_height; ++y) {
      for (int x = 30; x < 30 + rust_width; ++x) {
        constexpr std::array<float, 3> kRust{0.20F, 0.075F, 0.03F};
        std::copy(kRust.begin(), kRust.end(), color.pixel(x, y).begin());
      }
    }
  }
  return out;
}

TEST(FitObjective, RustedIsTheDifferenceOfTheAreasThatHaveRusted) {
  const TempFolder folder;
  const AgedSurface a = rusting_paint(48, 40), b = rusting_paint(32, 24);
  write_surface(folder.path() / "a", a, "0123456789abcdef");
  SurfaceOutline outline = outline_of(b);
  outline.control_names.clear();
  const FitObjective objective(open_series(folder.path() / "a").series, outline, {{FitFigure::Rusted}},
                               {.num_times = 2});
  // 20 % and 8 % at the last of two times; half a pixel along the edges is 0.9 % and 0.6 % of the picture.
  EXPECT_NEAR(objective(b).objective.value(), 0.5 * (20.0 - 8.0), 0.5 * (0.9 + 0.6));
  EXPECT_EQ(objective(a).objective.value(), 0.0);
}

TEST(FitObjective, IsTheWeightedMeanOfItsFigures) {
  const TempFolder folder;
  const AgedSurface a = green_plate(kGreenTruth), b = green_plate({0.15, 0.5, 0.0});
  write_surface(folder.path() / "a", a, "0123456789abcdef");
  const FitObjective objective(open_series(folder.path() / "a").series, outline_of(b),
                               {{FitFigure::MeanColor, 3.0}, {FitFigure::Covered, 0.5}}, {});
  const ObjectiveValue v = objective(b);
  EXPECT_DOUBLE_EQ(v.objective.value(), (3.0 * v.figures[0].value() + 0.5 * v.figures[1].value()) / 3.5);
}

TEST(FitObjective, OnTheClockOfSpansTheSpeedOfTheClockDoesNotMatter) {
  const TempFolder folder;
  const AgedSurface a = green_plate(kGreenTruth);
  AgedSurface slow = a;
  for (double& t : slow.times) t = 100.0 + 50.0 * t;
  slow.time_unit = TimeUnit::Hours;
  write_surface(folder.path() / "a", a, "0123456789abcdef");
  ObjectiveOptions options;
  options.clock = Clock::Span;
  const FitObjective objective(open_series(folder.path() / "a").series, outline_of(a), {{FitFigure::Ciede2000}},
                               options);
  EXPECT_NEAR(objective(slow).objective.value(), 0.0, kRounding);
}

TEST(FitObjective, ASurfaceThatEndsEarlierIsHeldAtItsEnd) {
  const TempFolder folder;
  const AgedSurface a = green_plate(kGreenTruth);
  AgedSurface still = a;  // All of it happens in a tenth of the time, then nothing.
  for (double& t : still.times) t *= 0.1;
  write_surface(folder.path() / "a", a, "0123456789abcdef");
  const FitObjective objective(open_series(folder.path() / "a").series, outline_of(a), {{FitFigure::Ciede2000}}, {});
  EXPECT_GT(objective(still).objective.value(), 2.0);
}

TEST(FitObjective, ASimulatedSurfaceInThePlaceOfTheCaptureIsComparedAsTheCaptureWouldBe) {
  const TempFolder folder;
  const AgedSurface a = green_plate(kGreenTruth), b = green_plate({0.15, 0.5, 0.0}),
                    other = green_plate({1.0, 1.0, 0.0});
  write_surface(folder.path() / "a", a, "0123456789abcdef");
  write_surface(folder.path() / "other", other, "0123456789abcdee");
  const FitObjective of_a(open_series(folder.path() / "a").series, outline_of(a), all_terms(), {});
  const FitObjective of_other(open_series(folder.path() / "other").series, outline_of(a), all_terms(), {});
  const ObjectiveValue direct = of_a(b), placed = of_other.with_captured(a, 1)(b);
  ASSERT_EQ(direct.figures.size(), placed.figures.size());
  for (std::size_t i = 0; i < direct.figures.size(); ++i)
    EXPECT_NEAR(direct.figures[i].value(), placed.figures[i].value(), kRounding) << kFitFigureNames[i];
}

TEST(FitObjective, IsThatOfEqualSizesOrOfEqualLengthsAPixelWhereBothAreKnown) {
  // One surface in texels of half the side: equal once both are means over the same lengths.
  const TempFolder folder;
  const AgedSurface coarse = green_plate(kGreenTruth);
  AgedSurface fine = coarse;
  fine.texel_size_mm = 0.5;
  fine.controls.clear();
  fine.mask = ImageU8(2 * coarse.mask.width(), 2 * coarse.mask.height());
  for (std::uint8_t& v : fine.mask.values()) v = 255;
  for (ImageF& color : fine.colors) {
    ImageF doubled(fine.mask.width(), fine.mask.height(), 3);
    for (int y = 0; y < doubled.height(); ++y) {
      for (int x = 0; x < doubled.width(); ++x) {
        // A grain of single texels, which no mean over two shows.
        const float sign = (x + y) % 2 == 0 ? 0.05f : -0.05f;
        for (int c = 0; c < 3; ++c) doubled.at(x, y, c) = color.at(x / 2, y / 2, c) + sign;
      }
    }
    color = std::move(doubled);
  }
  write_surface(folder.path() / "fine", fine, "0123456789abcdef");
  SurfaceOutline outline = outline_of(coarse);
  for (const std::optional<double> texel : {std::optional<double>(), std::optional(1.0)}) {
    outline.texel_size_mm = texel;
    const FitObjective objective(open_series(folder.path() / "fine").series, outline, {{}}, {});
    // Its colors are halves of means, the capture's means of halves: 2^-12 of a color, of which L* = 116 Y^(1/3) - 16
    // makes at most 116 / 3 * 2^-12 and a*, b* 500 / 3 and 200 / 3 times it.
    EXPECT_NEAR(objective(coarse).objective.value(), 0.0, std::hypot(116.0, 500.0, 200.0) / 3.0 / 4096.0);
  }
}

TEST(FitObjective, FramesUpToATimeAndThoseHeldOutMakeUpAllOfThem) {
  const TempFolder folder;
  const AgedSurface a = green_plate(kGreenTruth), b = green_plate({0.15, 0.5, 0.0});
  write_surface(folder.path() / "a", a, "0123456789abcdef");
  const auto series = [&] { return open_series(folder.path() / "a").series; };
  const std::vector<FitTerm> terms{{FitFigure::ColorDistribution}};  // A mean over times: at most 13, here 9.
  ObjectiveOptions options;
  const FitObjective all(series(), outline_of(b), terms, options);
  options.until = 5.0;
  const FitObjective seen(series(), outline_of(b), terms, options),
      held_out(series(), outline_of(b), terms, options, FitFrames::HeldOut);
  EXPECT_EQ(seen.num_times(), 6u);
  EXPECT_EQ(held_out.num_times(), 3u);
  EXPECT_NEAR(all(b).objective.value(), (6 * seen(b).objective.value() + 3 * held_out(b).objective.value()) / 9, 1e-9);
  // Later events are not seen.
  AgedSurface other = b;
  for (std::size_t t = 6; t < other.colors.size(); ++t) other.colors[t] = ImageF(24, 16, 3, 0.5f);
  EXPECT_EQ(seen(other).objective.value(), seen(b).objective.value());
  EXPECT_NE(held_out(other).objective.value(), held_out(b).objective.value());
  for (const auto& [until, part] : {std::pair{0.0, "fewer than two"}, {8.0, "no compared time lies after"}}) {
    options.until = until;
    const FitFrames frames = until > 1.0 ? FitFrames::HeldOut : FitFrames::Seen;
    EXPECT_TRUE(has(error_of([&] { (void)FitObjective(series(), outline_of(b), terms, options, frames); }), part));
  }
  EXPECT_TRUE(has(error_of([&] { (void)FitObjective(series(), outline_of(b), {{FitFigure::Onset}}, options); }),
                  "the whole course"));
}

TEST(FitParameter, RangesAreReadAndRefused) {
  const FitRange r = parse_fit_range("/rules/2/rate=0.001:0.1:log");
  EXPECT_EQ(r.name, "/rules/2/rate");
  EXPECT_EQ(r.low, 0.001);
  EXPECT_EQ(r.high, 0.1);
  EXPECT_EQ(r.scale, FitScale::Log);
  for (const auto& [text, part] : {std::pair{"rules/0=1:2", "JSON pointer"},
                                   {"/a", "LOW:HIGH"},
                                   {"/a=2:1", "upside down"},
                                   {"/a=1:1", "upside down"},
                                   {"/a=0:1:log", "above 0"},
                                   {"/a=x:1", "two numbers"},
                                   {"/a=0:1:lag", "did you mean `log`"},
                                   {"/a=1", "LOW:HIGH"}}) {
    EXPECT_TRUE(has(error_of<ParseError>([&text = text] { (void)parse_fit_range(text); }), part)) << text;
  }
  EXPECT_TRUE(has(error_of<ParseError>([] { (void)parse_fit_term("color_distributon"); }),
                  "did you mean `color_distribution`"));
  EXPECT_TRUE(has(error_of<ParseError>([] { (void)parse_fit_term("covered=-1"); }), "weight > 0"));
}

TEST(FitParameter, ValuesAndSharesOfTheRangeAreInverse) {
  const FitParameter linear{.range = {.name = "/a", .low = -2.0, .high = 6.0}, .start = 0.0},
      log{.range = {.name = "/b", .low = 0.01, .high = 100.0, .scale = FitScale::Log}, .start = 1.0};
  EXPECT_EQ(value_at(linear, 0.5), 2.0);
  EXPECT_EQ(value_at(log, 0.5), 1.0);
  for (const double u : {0.0, 0.1, 0.37, 0.9, 1.0}) {
    EXPECT_NEAR(unit_at(linear, value_at(linear, u)), u, 1e-6);  // Six digits.
    EXPECT_NEAR(unit_at(log, value_at(log, u)), u, 1e-6);
  }
  const FitParameter whole{.range = {.name = "/n", .low = 1.0, .high = 10.0}, .start = 5.0, .is_whole = true};
  EXPECT_EQ(value_at(whole, 0.42), 5.0);
}

}  // namespace
}  // namespace patinate::analysis
