#include "analysis/grading/surface_forecast.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

/// Of damage that does not heal.
constexpr std::array<std::string_view, 5> kHealsNever{"rusted_percent", "crack_mm_per_mm2", "creep_mm", "creep_max_mm",
                                                      "flaked_percent"};
constexpr int kForecastSteps = 24;

/// What a figure can be: areas end at the whole surface, and only differences of L*, a*, b* have a sign.
std::pair<double, double> possible_range(std::string_view figure) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const bool has_sign = figure == "delta_l" || figure == "delta_a" || figure == "delta_b";
  return {has_sign ? -kAny : 0.0, figure.ends_with("_percent") ? 100.0 : kAny};
}

/// Of one figure in all regions that have it at all times.
void add_forecast(std::string_view figure, GradedSurface& surface) {
  std::vector<std::vector<double>> series;
  std::vector<GradedRegion*> regions;
  for (GradedRegion& region : surface.regions) {
    std::vector<double> values;
    for (const std::optional<GradedFigure>& f : region.series(figure)) {
      if (f) values.push_back(f->value);
    }
    if (values.size() != surface.times.size()) continue;
    series.push_back(std::move(values));
    regions.push_back(&region);
  }
  if (series.empty()) return;
  const bool never_falls = std::find(kHealsNever.begin(), kHealsNever.end(), figure) != kHealsNever.end();
  const std::pair<double, double> range = possible_range(figure);
  const std::optional<GrowthForecast> made =
      forecast_growth(surface.times, series, surface.forecast_times, never_falls);
  if (!made) return;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    FigureForecast forecast{std::string(figure), made->test, made->values[r]};
    const GradedFigure last = *regions[r]->times.back().figure(figure);
    for (GradedFigure& f : forecast.values) {  // What is measured now is not certain either.
      f.low -= last.value - last.low;
      f.high += last.high - last.value;
      for (double* end : {&f.value, &f.low, &f.high}) *end = std::clamp(*end, range.first, range.second);
    }
    regions[r]->forecasts.push_back(std::move(forecast));
  }
}

/// Damage does not heal: a figure never falls, nor do the ends of its interval.
void keep_one_from_falling(GradedRegion& region, std::string_view name) {
  const auto at = static_cast<std::size_t>(std::find(kGradedFigureNames.begin(), kGradedFigureNames.end(), name) -
                                           kGradedFigureNames.begin());
  GradedFigure most{};
  for (RegionFigures& time : region.times) {
    std::optional<GradedFigure>& figure = time.figures[at];
    if (!figure) continue;
    most = {std::max(most.value, figure->value), std::max(most.low, figure->low), std::max(most.high, figure->high)};
    figure = most;
  }
}

}  // namespace

void keep_from_falling(GradedRegion& region) {
  for (const std::string_view name : kHealsNever) keep_one_from_falling(region, name);
}

void add_forecasts(double until, GradedSurface& surface) {
  const double last = surface.times.back();
  if (!(until > last))
    throw InvalidInput("--forecast: " + number_text(until) + " is not after the last photograph, " + number_text(last));
  for (int k = 1; k <= kForecastSteps; ++k)
    surface.forecast_times.push_back(last + (until - last) * k / kForecastSteps);
  for (const std::string_view figure : kGradedFigureNames) add_forecast(figure, surface);
  const bool is_any = std::any_of(surface.regions.begin(), surface.regions.end(),
                                  [](const GradedRegion& r) { return !r.forecasts.empty(); });
  if (is_any) return;
  surface.forecast_times.clear();
  surface.notes.push_back("nothing is forecast: that takes " + std::to_string(kMinForecastTimes) +
                          " photographs and a figure that changes");
}

ExtendedSeries extended_series(const GradedSurface& surface, const GradedRegion& region, std::string_view figure) {
  ExtendedSeries out{surface.times, region.series(figure)};
  for (const FigureForecast& forecast : region.forecasts) {
    if (forecast.figure != figure) continue;
    out.times.insert(out.times.end(), surface.forecast_times.begin(), surface.forecast_times.end());
    out.figures.insert(out.figures.end(), forecast.values.begin(), forecast.values.end());
  }
  return out;
}

}  // namespace patinate::analysis
