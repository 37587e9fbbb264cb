#include "analysis/fit/fit_charts.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "libcommon/core/text.h"
#include "libcommon/output/svg_chart.h"

namespace patinate::analysis {

namespace {

/// A curve of the comparison, nullptr where it is not told over time.
const Curve* curve_of(std::span<const Section> sections, const std::string& name) {
  for (const Section& s : sections) {
    const auto found = std::find_if(s.curves.begin(), s.curves.end(), [&](const Curve& c) { return c.name == name; });
    if (found != s.curves.end() && !found->columns.empty()) return &*found;
  }
  return nullptr;
}

/// From the least value to some times the rise that the data can tell: far ends of a range, where the objective is many
/// times that, would leave one flat line of the rest.
std::optional<std::pair<double, double>> rises_that_matter(const FitOutcome& o, const Chart& chart) {
  // Rises of the objective that the data can tell, above and below the best.
  constexpr double kShownRises = 5.0, kBelow = 0.25;
  const double best = *o.best.result.objective;
  double low = best, high = best;
  for (const ChartSeries& s : chart.series) {
    for (const std::optional<double>& v : s.y) {
      if (v) low = std::min(low, *v), high = std::max(high, *v);
    }
  }
  if (!(o.threshold > 0.0)) return std::nullopt;
  const double top = std::min(high, best + kShownRises * o.threshold);
  return std::pair{std::max(0.0, low - kBelow * o.threshold), top};
}

/// Keeps the part of every curve that the axis shows, and to each side of `best` one point more: it leaves the picture
/// there.
void keep_shown(Chart& chart, double best) {
  const double top = chart.y_range->second;
  for (ChartSeries& s : chart.series) {
    auto first = static_cast<std::size_t>(std::lower_bound(s.x.begin(), s.x.end(), best) - s.x.begin());
    std::size_t last = first;
    while (first > 0 && *s.y[first] <= top) --first;
    while (last + 1 < s.x.size() && *s.y[last] <= top) ++last;
    const auto cut = [&](auto& list) {
      using Place = std::ptrdiff_t;
      list = {list.begin() + static_cast<Place>(first), list.begin() + static_cast<Place>(last + 1)};
    };
    cut(s.x);
    cut(s.y);
  }
}

}  // namespace

std::string search_chart(const FitOutcome& o) {
  // Logarithmic: the first points lie far above, and what the last ones gain is a share of the best.
  Chart chart{
      .title = "The search", .x_label = "evaluation", .y_label = "objective", .log_y = *o.best.result.objective > 0.0};
  ChartSeries each{.name = "tried"}, best{.name = "best so far"};
  std::optional<double> least;
  double x = 0.0;
  // One evaluation: its appearances are what was tried.
  const bool are_appearances = o.searched.size() == 1;
  const auto add = [&](const std::optional<double>& value) {
    if (value) least = least ? std::min(*least, *value) : *value;
    each.x.push_back(x);
    each.y.push_back(value);
    best.x.push_back(x);
    best.y.push_back(least);
    x += 1.0;
  };
  for (const FitEvaluation& e : o.searched) {
    if (e.points.empty()) continue;
    if (are_appearances) {
      for (const FitPoint& p : e.points) add(p.result.objective);
    } else {
      const std::optional<std::size_t> i = e.best();
      add(i ? e.points[*i].result.objective : std::nullopt);
    }
  }
  each.is_dashed = true;
  chart.series = {std::move(best), std::move(each)};
  if (are_appearances) chart.x_label = "appearance";
  return svg_chart(chart);
}

std::string start_text(const std::string& name, std::span<const Section> before, std::span<const Section> after) {
  const Curve *first = curve_of(before, name), *last = curve_of(after, name);
  if (first == nullptr || last == nullptr || first->columns.front().values.empty()) return "";
  const std::string was = figure_text(first->columns.front().values.front()),
                    is = figure_text(last->columns.front().values.front());
  if (was != is || was == "-" || was == "0") return "";
  return "At the first compared time the distance is " + is +
         ", with the starting and with the best values. This is the error of the scene's initial surface, which the "
         "varied parameters do not change.";
}

std::string misfit_chart(const std::string& name, std::span<const Section> before, std::span<const Section> after) {
  const Curve *first = curve_of(before, name), *last = curve_of(after, name);
  if (first == nullptr || last == nullptr) return "";
  Chart chart{.title = last->title, .x_label = last->x_name, .y_label = last->y_name};
  chart.series.push_back({.name = "after", .x = last->x, .y = last->columns.front().values});
  chart.series.push_back({.name = "before", .x = first->x, .y = first->columns.front().values, .is_dashed = true});
  for (const CurveColumn& c : last->columns) {
    if (c.is_reference) chart.series.push_back({c.name, last->x, c.values, c.band, true});
  }
  return svg_chart(chart);
}

std::string scan_chart(const FitTask& task, const FitOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  Chart chart{.title = shown_name(p),
              .x_label = shown_name(p),
              .y_label = "objective",
              .log_x = p.range.scale == FitScale::Log};
  const auto line_of = [&](const std::string& name, const std::vector<BoxPoint>& list) {
    std::map<double, double> least{{o.best.values[i], *o.best.result.objective}};
    for (const BoxPoint& at : list) {
      const double value = value_at(p, at.at[i]);
      if (std::isfinite(at.objective) && (!least.contains(value) || at.objective < least[value]))
        least[value] = at.objective;
    }
    ChartSeries line{.name = name};
    for (const auto& [value, objective] : least) {
      line.x.push_back(value);
      line.y.emplace_back(objective);
    }
    return line;
  };
  chart.series = {line_of("others fixed at their best values", o.scans[i])};
  if (!o.profiles[i].empty()) chart.series.push_back(line_of("others moved with it", o.profiles[i]));
  chart.y_range = rises_that_matter(o, chart);
  if (chart.y_range) keep_shown(chart, o.best.values[i]);
  ChartSeries limit{.name = "distinguishable above this line", .is_dashed = true};
  double low = o.best.values[i], high = low;
  for (const ChartSeries& s : chart.series) low = std::min(low, s.x.front()), high = std::max(high, s.x.back());
  for (const double value : {low, high}) {
    limit.x.push_back(value);
    limit.y.emplace_back(*o.best.result.objective + o.threshold);
  }
  chart.series.push_back(std::move(limit));
  return svg_chart(chart);
}

}  // namespace patinate::analysis
