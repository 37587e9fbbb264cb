#include "libcommon/output/svg_chart.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libcommon/metrics/color_curves.h"
#include "libcommon/output/color_ramp.h"
#include "patinate/core/error.h"

namespace patinate {
namespace {

TEST(SvgChart, DrawsEverySeriesAndLeavesGapsWhereAValueIsMissing) {
  Chart chart{.title = "a < b", .x_label = "t", .y_label = "v"};
  chart.series.push_back({"one", {0, 1, 2, 3}, {0.0, 1.0, std::nullopt, 3.0}});
  chart.series.push_back({"two", {0, 1, 2, 3}, {1.0, 1.0, 1.0, 1.0}, {{0, 2}, {0, 2}, {0, 2}, {0, 2}}, true});
  const std::string svg = svg_chart(chart);
  EXPECT_EQ(svg.rfind("<svg", 0), 0u);
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
  EXPECT_NE(svg.find("stroke-dasharray"), std::string::npos);
  const std::string line = svg.substr(svg.find("fill=\"none\"") - 60, 60);
  EXPECT_EQ(std::count(line.begin(), line.end(), 'M'), 2);  // The path begins again after the gap.
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg, svg_chart(chart));
}

TEST(SvgChart, RefusesWhatIsNoNumberAndSaysWhenThereIsNone) {
  Chart chart{.title = "t", .x_label = "x", .y_label = "y"};
  EXPECT_NE(svg_chart(chart).find("no values"), std::string::npos);
  chart.series.push_back({"one", {0, 1}, {0.0, std::nan("")}});
  EXPECT_THROW((void)svg_chart(chart), InvalidInput);
  chart.series[0].y = {0.0};
  EXPECT_THROW((void)svg_chart(chart), InvalidInput);
  chart.series[0].y = {5.0, 5.0};  // Constant: still an axis.
  EXPECT_EQ(svg_chart(chart).find("nan"), std::string::npos);
}

TEST(SvgChart, WithARangeOfItsOwnItsCurvesEndAtTheAxesAndTicksAreOfTheRange) {
  Chart chart{.title = "t", .x_label = "x", .y_label = "y", .y_range = std::pair{2.0, 3.0}};
  chart.series.push_back({"one", {0, 1, 2}, {2.1, 2.2, 900.0}});
  const std::string svg = svg_chart(chart);
  EXPECT_NE(svg.find(">2.2<"), std::string::npos);  // Steps of 0.2.
  EXPECT_EQ(svg.find(">500<"), std::string::npos);
  // The lines lie in a picture of their own, as large as the axes, which hides what lies outside.
  const std::size_t inner = svg.find("<svg", 4);
  ASSERT_NE(inner, std::string::npos);
  EXPECT_NE(svg.find("viewBox=\"64 34 542 220\"", inner), std::string::npos);
  EXPECT_GT(svg.find("fill=\"none\""), inner);
  chart.y_range = std::pair{3.0, 3.0};
  EXPECT_THROW((void)svg_chart(chart), InvalidInput);
}

TEST(SvgChart, LogarithmicAxesOfLessThanADecadeHaveEvenSteps) {
  Chart chart{.title = "t", .x_label = "x", .y_label = "y", .log_y = true};
  chart.series.push_back({"one", {0, 1}, {8.7, 18.3}});
  const std::string svg = svg_chart(chart);
  for (const char* tick : {">10<", ">12<", ">14<", ">16<", ">18<"})
    EXPECT_NE(svg.find(tick), std::string::npos) << tick;
}

TEST(ColorRamp, GrowsLighterInEqualStepsAndKeepsItsMiddleWhite) {
  double before = -1.0;
  for (int i = 0; i <= 10; ++i) {
    const auto rgb = ramp_color(ColorRamp::Sequential, i / 10.0);
    const double lightness =
        lab_from_linear(static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2]))[0];
    if (i > 0) {
      EXPECT_NEAR(lightness - before, 7.2, 1e-3) << i;  // 16 to 88 in ten steps, all inside the gamut.
    }
    before = lightness;
  }
  const auto middle = ramp_color(ColorRamp::Diverging, 0.5);
  EXPECT_NEAR(static_cast<double>(middle[0]), static_cast<double>(middle[2]), 1e-3);
  EXPECT_THROW((void)ramp_picture(ImageF(2, 2), {}, 1.0, 1.0, ColorRamp::Sequential), InvalidInput);
}

}  // namespace
}  // namespace patinate
