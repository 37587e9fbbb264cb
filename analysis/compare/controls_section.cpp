// Two surfaces by what their ageing follows.
#include <algorithm>
#include <cmath>

#include "analysis/compare/aging.h"
#include "analysis/compare/control_classes.h"
#include "analysis/compare/sections.h"
#include "analysis/compare/sliced_distance.h"
#include "libcommon/core/text.h"
#include "libcommon/metrics/correlation.h"

namespace patinate {

namespace {

constexpr std::size_t kMostTimes = 5, kMostSamples = 1024;
constexpr std::uint32_t kConditionalPurpose = 301, kRatePurpose = 302;

/// Texels of a side by class, with how far each has changed.
struct Classes {
  const ColorStack* stack;
  const BlockGrid* grid;
  std::vector<float> values;
  std::vector<int> class_of;
  std::vector<float> change;
  std::vector<std::vector<SortedColors>> colors;  ///< [class][time]
};

Classes classes_of(const TextureSeries& series, const ColorStack& stack, const BlockGrid& grid, const std::string& name, const SharedControl& shared, const CompareOptions& options) {
  Classes c{&stack, &grid, control_at(series, name, stack), {}, {}, {}};
  c.class_of = control_classes(c.values, series.history().control(name), shared, options.num_classes);
  if (stack.num_times() > 1) c.change = texel_aging(stack, options.visible_delta_e).change;
  for (int k = 0; k < options.num_classes; ++k) {
    std::vector<std::uint32_t> texels;
    for (std::size_t i = 0; i < c.class_of.size(); ++i) {
      if (c.class_of[i] == k) texels.push_back(static_cast<std::uint32_t>(i));
    }
    c.colors.emplace_back();
    for (const std::size_t t : spread_indices(stack.num_times(), kMostTimes)) c.colors.back().emplace_back(stack, t, texels, grid.block_of, kMostSamples, options.seed);
  }
  return c;
}

/// Mean over the classes and times that both have; then every class by itself is not returned, since resamples may lack it.
std::vector<double> conditional_distance(const Classes& a, const std::vector<int>& wa, const Classes& b, const std::vector<int>& wb) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < a.colors.size(); ++k) {
    for (std::size_t t = 0; t < a.colors[k].size(); ++t) {
      const std::optional<double> d = sliced_distance(a.colors[k][t], wa, b.colors[k][t], wb);
      if (!d) continue;
      sum += *d;
      ++count;
    }
  }
  return count == 0 ? std::vector<double>() : std::vector<double>{sum / count};
}

/// Mean change per time of every class, Delta E 1976; nothing where a class has no weight.
std::vector<std::optional<double>> rates(const Classes& c, const std::vector<int>& weights, std::size_t num_classes) {
  std::vector<double> sum(num_classes), count(num_classes);
  for (std::size_t i = 0; i < c.class_of.size(); ++i) {
    if (c.class_of[i] < 0) continue;
    const double w = weights[c.grid->block_of[i]];
    sum[static_cast<std::size_t>(c.class_of[i])] += w * static_cast<double>(c.change[i]);
    count[static_cast<std::size_t>(c.class_of[i])] += w;
  }
  const double span = c.stack->times.back() - c.stack->times.front();
  std::vector<std::optional<double>> out(num_classes);
  for (std::size_t k = 0; k < num_classes; ++k) {
    if (count[k] > 0.0) out[k] = sum[k] / count[k] / span;
  }
  return out;
}

std::vector<double> rate_distance(const Classes& a, const std::vector<int>& wa, const Classes& b, const std::vector<int>& wb) {
  const std::vector<std::optional<double>> x = rates(a, wa, a.colors.size()), y = rates(b, wb, b.colors.size());
  double sum = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!x[k] || !y[k]) continue;
    sum += (*x[k] - *y[k]) * (*x[k] - *y[k]);
    ++count;
  }
  return count == 0 ? std::vector<double>() : std::vector<double>{std::sqrt(sum / count)};
}

void add_rates(const ComparedPair& pair, const Classes& a, const Classes& b, const SharedControl& shared, const CompareOptions& options, const RunControl& control, Section& section) {
  const std::string unit = "Delta E 1976 per " + (pair.time_unit == "spans" ? std::string("span") : pair.time_unit);
  const auto figure = [](const Classes& one, const Classes& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) { return rate_distance(one, wa, other, wb); };
  };
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, kRatePurpose, control);
  section.figures.push_back(figure_of(f, 0, "rate_by_" + shared.name_a, "Rate of change by " + shared.name_a + ": root mean square difference over classes", unit, "the two sides share no class of the control"));
  Curve curve{.name = "rate_by_" + shared.name_a, .title = "Rate of change by " + shared.name_a, .x_name = "", .y_name = unit, .x = {}, .columns = {}};
  const double classes = options.num_classes;
  const bool is_physical = shared.rule == ClassRule::Physical;
  curve.x_name = is_physical ? shared.name_a + (shared.unit.empty() ? "" : " (" + shared.unit + ")") : shared.name_a + " (rank)";
  for (int k = 0; k < options.num_classes; ++k) curve.x.push_back(is_physical ? shared.low + (k + 0.5) / classes * (shared.high - shared.low) : (k + 0.5) / classes);
  curve.columns.push_back({"A", rates(a, pair.blocks_a.all(), a.colors.size())});
  curve.columns.push_back({"B", rates(b, pair.blocks_b.all(), b.colors.size())});
  section.curves.push_back(std::move(curve));
  for (const Classes* c : {&a, &b}) {
    const std::string side = c == &a ? "a" : "b";
    Figure rank{.name = "rank_correlation_" + shared.name_a + "_" + side, .title = std::string("Rank correlation of ") + shared.name_a + " and change, " + (c == &a ? "A" : "B"), .unit = ""};
    if (c->values.size() < 2) {
      rank.undefined = "there is only one texel";
    } else {
      rank.value = rank_correlation(std::vector<double>(c->values.begin(), c->values.end()), std::vector<double>(c->change.begin(), c->change.end()));
    }
    section.figures.push_back(std::move(rank));
  }
}

void add_control(const ComparedPair& pair, const SharedControl& shared, const CompareOptions& options, const RunControl& control, Section& section) {
  const std::string name = "color_by_" + shared.name_a, title = "Colour given " + shared.name_a + " and time: distance between the distributions, mean over classes and times";
  if (!shared.undefined.empty()) {
    section.figures.push_back({.name = name, .title = title, .unit = "Delta E 1976", .undefined = shared.undefined});
    return;
  }
  if (!shared.note.empty()) section.paragraphs.push_back(shared.name_a + (shared.name_a == shared.name_b ? "" : " against " + shared.name_b) + ": classes " + shared.note + ".");
  const Classes a = classes_of(pair.series_a, pair.a, pair.blocks_a, shared.name_a, shared, options), b = classes_of(pair.series_b, pair.b, pair.blocks_b, shared.name_b, shared, options);
  const auto figure = [](const Classes& one, const Classes& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) { return conditional_distance(one, wa, other, wb); };
  };
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, kConditionalPurpose, control.part(0.0, 0.8));
  section.figures.push_back(figure_of(f, 0, name, title, "Delta E 1976", "the two sides share no class of the control"));
  if (pair.a.num_times() > 1) {
    add_rates(pair, a, b, shared, options, control.part(0.8, 1.0), section);
  } else {
    section.figures.push_back({.name = "rate_by_" + shared.name_a, .title = "Rate of change by " + shared.name_a, .unit = "", .undefined = "there is only one common time"});
  }
}

std::string names_of(const HistoryManifest& m) {
  std::string text;
  for (const ControlParameter& c : m.controls) text += (text.empty() ? "" : ", ") + c.name;
  return text.empty() ? "none" : text;
}

}  // namespace

Section controls_section(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  Section section{.name = "controls", .title = "By control"};
  const std::vector<SharedControl> shared = shared_controls(pair.series_a.manifest(), pair.series_b.manifest());
  if (shared.empty()) section.undefined = "no control is common to both (A: " + names_of(pair.series_a.manifest()) + "; B: " + names_of(pair.series_b.manifest()) + ")";
  for (std::size_t k = 0; k < shared.size(); ++k) {
    const auto n = static_cast<double>(shared.size());
    add_control(pair, shared[k], options, control.part(static_cast<double>(k) / n, (static_cast<double>(k) + 1.0) / n), section);
  }
  return section;
}

}  // namespace patinate
