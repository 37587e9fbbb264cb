// Objective of a fit, and the times at which it counts.
#include <algorithm>
#include <array>

#include "analysis/fit/fit_objective.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

HistoryFacts facts_of(const SurfaceOutline& outline) {
  HistoryFacts m;
  m.time_unit = outline.time_unit;
  for (double t : outline.times) m.frames.push_back({.time = t});
  return m;
}

/// The times up to `until`, or those after it.
CommonTimes times_until(const CommonTimes& all, double until, FitFrames frames, const std::string& name) {
  CommonTimes kept;
  for (std::size_t i = 0; i < all.clock.size(); ++i) {
    if ((all.times_a[i] <= until) != (frames == FitFrames::Seen)) continue;
    kept.clock.push_back(all.clock[i]);
    kept.times_a.push_back(all.times_a[i]);
    kept.times_b.push_back(all.times_b[i]);
  }
  if (frames == FitFrames::Seen && kept.clock.size() < 2)
    throw InvalidInput(name + ": fewer than two compared times lie up to --until " + short_number_text(until));
  if (kept.clock.empty())
    throw InvalidInput(name + ": no compared time lies after --until " + short_number_text(until));
  return kept;
}

}  // namespace

FitTerm parse_fit_term(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  const auto found = std::find(kFitFigureNames.begin(), kFitFigureNames.end(), name);
  if (found == kFitFigureNames.end()) {
    const std::vector<std::string> names(kFitFigureNames.begin(), kFitFigureNames.end());
    std::string list;
    for (const std::string& n : names) list += (list.empty() ? "" : ", ") + n;
    throw ParseError("--objective: found `" + name + "`; expected one of " + list + did_you_mean(name, names));
  }
  FitTerm term{.figure = static_cast<FitFigure>(found - kFitFigureNames.begin())};
  if (equals == std::string::npos) return term;
  const std::optional<double> weight = parse_number(text.substr(equals + 1));
  if (!weight || !(*weight > 0.0))
    throw ParseError("--objective: found `" + text + "`; expected NAME=WEIGHT with a weight > 0");
  term.weight = *weight;
  return term;
}

void describe(OptionVisitor& v, ObjectiveOptions& o) {
  v.visit({"size", "Longer side at which the surfaces are compared; 0 = as they are", "px", between(0, 65536)}, o.size);
  v.visit({"num_times", "Largest number of times at which they are compared", "", between(2, 1024)}, o.num_times);
  v.visit_choice({"clock", "Compare at equal times, or at equal shares of each history's span"}, o.clock, kClockNames);
  v.visit({"until", "Last time that is fitted, in the history's unit; later frames are held out for evaluation", "",
           Range{}},
          o.until);
  v.visit({"visible_delta_e", "Smallest visible change of color", "Delta E 1976", above(0)}, o.visible_delta_e);
  v.visit({"num_classes", "Classes of a control", "", between(1, 50)}, o.num_classes);
  v.visit(
      {"samples", "Largest number of places per time that color_distribution compares; 0 = all", "", between(0, 65536)},
      o.samples);
}

CommonTimes fit_times(const HistoryFacts& captured, const SurfaceOutline& outline, const ObjectiveOptions& options,
                      FitFrames frames, const std::string& name) {
  CommonTimes times = common_times(captured, facts_of(outline), compare_options(options));
  return options.until ? times_until(times, *options.until, frames, name) : times;
}

CompareOptions compare_options(const ObjectiveOptions& o) {
  CompareOptions c;
  c.size = o.size;
  c.num_times = o.num_times;
  c.clock = o.clock;
  c.visible_delta_e = o.visible_delta_e;
  c.num_classes = o.num_classes;
  return c;
}

}  // namespace patinate::analysis
