#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "analysis/compare/sections.h"
#include "analysis/figures/material_stack.h"
#include "patinate/history/memory_history.h"

namespace patinate::analysis {
namespace {

constexpr int kStatedSide = 12;

/// A gray surface at two times; `gloss`: strength and roughness of the highlight, `metalness`.
struct Stated {
  float color = 0.5f;
  std::optional<float> strength = {}, roughness = {}, metalness = {};
  float later = 0.0f;  ///< Added to the roughness at the second time.
  double span = 10.0;  ///< The second time.
};

TextureSeries series_of(const Stated& stated) {
  MemoryHistoryImages images{.name = "test", .frames = {}};
  for (int k = 0; k < 2; ++k) {
    MemoryFrame frame{.time = stated.span * k, .color = ImageF(kStatedSide, kStatedSide, 3)};
    std::fill(frame.color.values().begin(), frame.color.values().end(), stated.color);
    if (stated.roughness) {
      ImageF gloss(kStatedSide, kStatedSide, 2);
      for (std::int64_t i = 0; i < gloss.num_pixels(); ++i) {
        gloss.data()[2 * i] = stated.strength.value_or(0.04f);
        gloss.data()[2 * i + 1] = *stated.roughness + static_cast<float>(k) * stated.later;
      }
      frame.extras.push_back({"specular", gloss});
    }
    if (stated.metalness) {
      ImageF metal(kStatedSide, kStatedSide);
      std::fill(metal.values().begin(), metal.values().end(), *stated.metalness);
      frame.extras.push_back({"metalness", metal});
    }
    images.frames.push_back(std::move(frame));
  }
  return TextureSeries(std::make_shared<const MemoryHistory>(std::move(images)));
}

Section compared_materials(const Stated& a, const Stated& b) {
  const CompareOptions options{.places = Places::Equal, .num_resamples = 0};
  return materials_section(load_pair(series_of(a), series_of(b), options), options);
}

double section_value(const Section& section, const std::string& name) {
  for (const Figure& f : section.figures) {
    if (f.name == name) return f.value.value();
  }
  ADD_FAILURE() << "no " << name;
  return -1.0;
}

TEST(ComparedMaterials, AreSaidOnlyWhereASideStatesThem) {
  EXPECT_FALSE(states_material(series_of({}).facts()));
  EXPECT_TRUE(states_material(series_of({.roughness = 0.4f}).facts()));
  const auto names = [](const Stated& a, const Stated& b) {
    std::vector<std::string> out;
    for (const NamedSection& s : compared_sections({}, series_of(a).facts(), series_of(b).facts()))
      out.push_back(s.name);
    return out;
  };
  const auto has = [](const std::vector<std::string>& v) { return std::count(v.begin(), v.end(), "materials"); };
  EXPECT_EQ(has(names({}, {})), 0);
  EXPECT_EQ(has(names({}, {.roughness = 0.4f})), 1);
}

TEST(ComparedMaterials, EqualOnesAreNowhereApart) {
  const Stated stated{.strength = 0.05f, .roughness = 0.3f, .metalness = 0.5f};
  for (const Figure& f : compared_materials(stated, stated).figures) EXPECT_EQ(f.value, 0.0) << f.name;
}

TEST(ComparedMaterials, DistancesAreThoseOfTheStatedNumbersAndCurvesTheirCourse) {
  const Section s = compared_materials({.strength = 0.05f, .roughness = 0.3f, .metalness = 0.0f},
                                       {.strength = 0.05f, .roughness = 0.6f, .metalness = 1.0f, .later = 0.2f});
  EXPECT_NEAR(section_value(s, "roughness_distance"), 0.4, 1e-6) << "0.3 and then 0.5";
  EXPECT_NEAR(section_value(s, "metalness_distance"), 1.0, 1e-6);
  EXPECT_NEAR(section_value(s, "reflectance_distance"), 0.45, 1e-6) << "metal reflects its color";
  EXPECT_GT(section_value(s, "brdf_distance"), 0.0);
  EXPECT_NEAR(section_value(s, "brdf_distance"), section_value(s, "brdf_by_place"), 1e-6) << "every place is the same";
  for (const Curve& c : s.curves) {
    if (c.name != "roughness") continue;
    EXPECT_NEAR(c.columns[0].values[1].value(), 0.3, 1e-6);
    EXPECT_NEAR(c.columns[1].values[1].value(), 0.8, 1e-6);
  }
}

TEST(ComparedMaterials, AreReadAtEachHistorysOwnTimesOnTheClockOfSpans) {
  const Stated quick{.roughness = 0.3f, .later = 0.4f}, slow{.roughness = 0.3f, .later = 0.4f, .span = 1000.0};
  const CompareOptions options{.clock = Clock::Span, .places = Places::Equal, .num_resamples = 0};
  const Section s = materials_section(load_pair(series_of(quick), series_of(slow), options), options);
  EXPECT_NEAR(section_value(s, "roughness_distance"), 0.0, 1e-6) << "the same course over its span";
  for (const Curve& c : s.curves) {
    if (c.name != "roughness") continue;
    EXPECT_NEAR(c.columns[1].values.back().value(), 0.7, 1e-6) << "the slow one's end";
  }
}

TEST(ComparedMaterials, DistanceOfMattSurfacesIsThatOfTheLogarithms) {
  // Without a mirror f = albedo / pi, whatever the view: log(1 + albedo cos / pi) at 0 degrees once, at five others
  // three times.
  const auto level = [](double albedo, double degrees) {
    return std::log1p(albedo * std::cos(degrees * std::numbers::pi / 180.0) / std::numbers::pi);
  };
  const auto square = [&](double degrees) { return std::pow(level(0.8, degrees) - level(0.2, degrees), 2); };
  double sum = square(0.0);
  for (const double degrees : {15.0, 30.0, 45.0, 60.0, 75.0}) sum += 3.0 * square(degrees);
  const Section s = compared_materials({.color = 0.8f, .strength = 0.0f, .roughness = 0.5f},
                                       {.color = 0.2f, .strength = 0.0f, .roughness = 0.5f});
  EXPECT_NEAR(section_value(s, "brdf_distance"), std::sqrt(sum / 16.0), 1e-5);
  EXPECT_NEAR(section_value(s, "roughness_distance"), 0.0, 1e-6);
}

TEST(ComparedMaterials, ASideThatStatesNothingIsADullDielectric) {
  const Section s = compared_materials({}, {.strength = 0.04f, .roughness = 0.8f, .metalness = 0.0f});
  for (const Figure& f : s.figures) EXPECT_NEAR(f.value.value(), 0.0, 1e-6) << f.name;
  ASSERT_EQ(s.paragraphs.size(), 2u);
  EXPECT_NE(s.paragraphs[1].find("A says nothing of its material"), std::string::npos);
}

/// Heights of a surface at times 0 and 10.
using Heights = std::function<double(int x, int y, int time)>;
TextureSeries relief_of(const Heights& heights, const std::string& origin) {
  MemoryHistoryImages images{.name = "test", .origin = origin, .frames = {}};
  for (int k = 0; k < 2; ++k) {
    MemoryFrame frame{.time = 10.0 * k, .color = ImageF(kStatedSide, kStatedSide, 3, 0.5f)};
    ImageF height(kStatedSide, kStatedSide);
    for (int y = 0; y < kStatedSide; ++y) {
      for (int x = 0; x < kStatedSide; ++x) height.at(x, y) = static_cast<float>(heights(x, y, k));
    }
    frame.extras.push_back({"height", height});
    images.frames.push_back(std::move(frame));
  }
  return TextureSeries(std::make_shared<const MemoryHistory>(std::move(images)));
}
Section compared_relief(const Heights& a, const Heights& b, const std::string& origin = "captured") {
  const CompareOptions options{.places = Places::Equal, .num_resamples = 0};
  return materials_section(load_pair(relief_of(a, origin), relief_of(b, origin), options), options);
}
/// Small bumps: a chess board of plus and minus `amount`, which has neither mean nor slope.
double bumps(int x, int y, double amount) { return (x / 3 + y / 3) % 2 == 0 ? amount : -amount; }

TEST(ComparedMaterials, HeightsOfOneReliefAreNotApartWhereverItLay) {
  const Heights flat = [](int x, int y, int k) { return bumps(x, y, 0.2) + 0.1 * k; };
  const Heights tilted = [](int x, int y, int k) { return bumps(x, y, 0.2) + 0.1 * k + 7.0 + 0.05 * x - 0.02 * y; };
  const Section s = compared_relief(flat, tilted);
  // Heights of 7 mm are floats of 5e-7.
  EXPECT_NEAR(section_value(s, "height_distance"), 0.0, 2e-6);
  EXPECT_NEAR(section_value(s, "growth_distance"), 0.0, 2e-6);
  ASSERT_EQ(s.paragraphs.size(), 2u);
  // The middle is 7 + 5.5 (0.05 - 0.02) high, the corners 11 (0.05 + 0.02) apart.
  EXPECT_NE(s.paragraphs[1].find("of B: the mean of its first time, 7.165 mm, and the tilt of the plane through it, "
                                 "0.77 mm over the surface"),
            std::string::npos)
      << s.paragraphs[1];
}

TEST(ComparedMaterials, OfHeightsOnAMeshTheMeanIsTakenAndNoTilt) {
  const Heights level = [](int, int, int) { return 0.0; };
  const Heights ramp = [](int x, int, int) { return 3.0 + 0.1 * (x - 0.5 * (kStatedSide - 1)); };
  // The ramp's heights are 0.1 (x - 5.5): the mean of their amounts is 0.3.
  EXPECT_NEAR(section_value(compared_relief(level, ramp, "simulated"), "height_distance"), 0.3, 1e-6);
  EXPECT_NEAR(section_value(compared_relief(level, ramp, "captured"), "height_distance"), 0.0, 1e-6);
}

TEST(ComparedMaterials, ReliefThatGrowsIsApartByWhatItGrew) {
  const Heights low = [](int x, int y, int k) { return bumps(x, y, 0.1) + 0.05 * k; };
  const Heights high = [](int x, int y, int k) { return 2.0 + bumps(x, y, 0.3) + 0.25 * k; };
  const Section s = compared_relief(low, high);
  // Growth: 0 and 0.2. Heights: bumps are 0.2 apart at first; then those of -0.1 + 0.05 and -0.3 + 0.25 are equal, and
  // those of 0.15 and 0.55 are 0.4 apart.
  EXPECT_NEAR(section_value(s, "growth_distance"), 0.1, 1e-6);
  EXPECT_NEAR(section_value(s, "height_distance"), 0.2, 1e-6);
  for (const Curve& c : s.curves) {
    if (c.name != "growth") continue;
    EXPECT_NEAR(c.columns[0].values[1].value(), 0.05, 1e-6);
    EXPECT_NEAR(c.columns[1].values[1].value(), 0.25, 1e-6);
  }
}

TEST(ComparedMaterials, GlossThatDivergesIsFartherThanOneThatDoesNot) {
  const Stated matt{.roughness = 0.7f}, shiny{.roughness = 0.2f}, between{.roughness = 0.45f};
  EXPECT_GT(section_value(compared_materials(matt, shiny), "brdf_distance"),
            section_value(compared_materials(matt, between), "brdf_distance"));
}

}  // namespace
}  // namespace patinate::analysis
