#include "analysis/grading/grade_times.h"

#include <algorithm>

namespace patinate::analysis {

namespace {

struct Known {
  std::vector<double> times;
  std::vector<GradedFigure> figures;
};

Known known(std::span<const double> times, std::span<const std::optional<GradedFigure>> figures) {
  Known out;
  for (std::size_t t = 0; t < times.size(); ++t) {
    if (!figures[t]) continue;
    out.times.push_back(times[t]);
    out.figures.push_back(*figures[t]);
  }
  return out;
}

GradeTime time_of(std::size_t grade, double border, const Known& series, double least) {
  GradeTime out{.grade = grade};
  // What is too little to be seen does not pass a border.
  const double limit = std::max(border, least);
  const std::size_t n = series.times.size();
  const auto first = [&](double GradedFigure::*end) {
    std::size_t t = 0;
    while (t < n && !(series.figures[t].*end > limit)) ++t;
    return t;
  };
  const std::size_t passed = first(&GradedFigure::value), may_have = first(&GradedFigure::high),
                    must_have = first(&GradedFigure::low);
  // It may have passed right after the last photograph on which even the upper end is below, and has passed by the
  // first on which even the lower end is above.
  if (may_have > 0 && may_have < n) out.earliest = series.times[may_have - 1];
  if (must_have < n) out.latest = series.times[must_have];
  if (passed == n) {
    out.state = border < least && may_have < n ? Reached::NotResolved : Reached::NotReached;
    return out;
  }
  if (passed == 0) {
    out.state = Reached::BeforeFirst;
    out.earliest.reset();
    return out;
  }
  out.state = Reached::Reached;
  const double a = series.figures[passed - 1].value, b = series.figures[passed].value;
  // More than nothing is more than what the photograph before may have passed over.
  const double at = border > 0.0 ? limit : std::min(std::max(limit, series.figures[passed - 1].high), b);
  out.time = series.times[passed - 1] + (at - a) / (b - a) * (series.times[passed] - series.times[passed - 1]);
  return out;
}

}  // namespace

std::vector<GradeTime> grade_times(const GradeScale& scale, std::span<const double> times,
                                   std::span<const std::optional<GradedFigure>> figures, double least,
                                   double last_seen) {
  const Known series = known(times, figures);
  std::vector<GradeTime> out;
  if (series.times.empty()) return out;
  for (std::size_t g = 1; g < scale.grades.size(); ++g) {
    GradeTime time = time_of(g, scale.grades[g - 1].up_to, series, least);
    if (time.state == Reached::Reached && *time.time > last_seen) time.state = Reached::Forecast;
    out.push_back(time);
  }
  return out;
}

std::optional<GradedFigure> figure_at(std::span<const double> times,
                                      std::span<const std::optional<GradedFigure>> figures, double time) {
  const Known series = known(times, figures);
  if (series.times.empty() || time < series.times.front() || time > series.times.back()) return std::nullopt;
  const auto after = std::lower_bound(series.times.begin(), series.times.end(), time);
  const auto b = static_cast<std::size_t>(after - series.times.begin());
  if (series.times[b] == time) return series.figures[b];
  const double share = (time - series.times[b - 1]) / (series.times[b] - series.times[b - 1]);
  const GradedFigure &from = series.figures[b - 1], &to = series.figures[b];
  const auto between = [share](double x, double y) { return x + share * (y - x); };
  return GradedFigure{between(from.value, to.value), between(from.low, to.low), between(from.high, to.high)};
}

}  // namespace patinate::analysis
