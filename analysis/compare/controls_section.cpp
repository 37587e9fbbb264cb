// Two surfaces by what their aging follows.
#include <algorithm>
#include <cmath>

#include "analysis/compare/control_figures.h"
#include "analysis/compare/sections.h"
#include "libcommon/core/text.h"
#include "libcommon/metrics/correlation.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kConditionalPurpose = 301, kRatePurpose = 302;

std::vector<double> as_list(const std::optional<double>& value) {
  return value ? std::vector<double>{*value} : std::vector<double>();
}

void add_rates(const ComparedPair& pair, const ClassedSurface& a, const ClassedSurface& b, const SharedControl& shared,
               const CompareOptions& options, const RunControl& control, Section& section) {
  const std::string unit = "Delta E 1976 per " + (pair.time_unit == "spans" ? std::string("span") : pair.time_unit);
  const auto figure = [](const ClassedSurface& one, const ClassedSurface& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      return as_list(rate_distance(one, wa, other, wb));
    };
  };
  const SplitFigure f = split_figure(pair, figure(a, b), figure(a, a), options, kRatePurpose, control);
  section.figures.push_back(
      figure_of(f, 0, "rate_by_" + shared.name_a,
                "Rate of change by " + shared.name_a + ": root mean square difference over classes", unit,
                "the two sides share no class of the control"));
  Curve curve{.name = "rate_by_" + shared.name_a,
              .title = "Rate of change by " + shared.name_a,
              .x_name = "",
              .y_name = unit,
              .x = {},
              .columns = {}};
  const double classes = options.num_classes;
  const bool is_physical = shared.rule == ClassRule::Physical;
  curve.x_name =
      is_physical ? shared.name_a + (shared.unit.empty() ? "" : " (" + shared.unit + ")") : shared.name_a + " (rank)";
  for (int k = 0; k < options.num_classes; ++k)
    curve.x.push_back(is_physical ? shared.low + (k + 0.5) / classes * (shared.high - shared.low)
                                  : (k + 0.5) / classes);
  curve.columns.push_back({"A", a.rates(pair.blocks_a.all())});
  curve.columns.push_back({"B", b.rates(pair.blocks_b.all())});
  section.curves.push_back(std::move(curve));
  for (const ClassedSurface* c : {&a, &b}) {
    const std::string side = c == &a ? "a" : "b";
    Figure rank{.name = "rank_correlation_" + shared.name_a + "_" + side,
                .title = std::string("Rank correlation of ") + shared.name_a + " and change, " + (c == &a ? "A" : "B"),
                .unit = ""};
    if (c->values().size() < 2) {
      rank.undefined = "there is only one texel";
    } else {
      rank.value = rank_correlation(std::vector<double>(c->values().begin(), c->values().end()),
                                    std::vector<double>(c->change().begin(), c->change().end()));
    }
    section.figures.push_back(std::move(rank));
  }
}

void add_control(const ComparedPair& pair, const SharedControl& shared, const CompareOptions& options,
                 const RunControl& control, Section& section) {
  const std::string name = "color_by_" + shared.name_a,
                    title = "Color given " + shared.name_a +
                            " and time: distance between the distributions, mean over classes and times";
  if (!shared.undefined.empty()) {
    section.figures.push_back({.name = name, .title = title, .unit = "Delta E 1976", .undefined = shared.undefined});
    return;
  }
  if (!shared.note.empty())
    section.paragraphs.push_back(shared.name_a + (shared.name_a == shared.name_b ? "" : " against " + shared.name_b) +
                                 ": classes " + shared.note + ".");
  const auto classed = [&](const TextureSeries& series, const ColorStack& stack, const BlockGrid& grid,
                           const std::string& control_name) {
    return ClassedSurface(stack, grid.block_of, control_at(series, control_name, stack),
                          series.history().control(control_name), shared, options.num_classes, options.seed);
  };
  const ClassedSurface a = classed(pair.series_a, pair.a, pair.blocks_a, shared.name_a),
                       b = classed(pair.series_b, pair.b, pair.blocks_b, shared.name_b);
  const auto figure = [](const ClassedSurface& one, const ClassedSurface& other) {
    return [&one, &other](const std::vector<int>& wa, const std::vector<int>& wb) {
      return as_list(conditional_distance(one, wa, other, wb));
    };
  };
  const SplitFigure f =
      split_figure(pair, figure(a, b), figure(a, a), options, kConditionalPurpose, control.part(0.0, 0.8));
  section.figures.push_back(
      figure_of(f, 0, name, title, "Delta E 1976", "the two sides share no class of the control"));
  if (pair.a.num_times() > 1) {
    add_rates(pair, a, b, shared, options, control.part(0.8, 1.0), section);
  } else {
    section.figures.push_back({.name = "rate_by_" + shared.name_a,
                               .title = "Rate of change by " + shared.name_a,
                               .unit = "",
                               .undefined = "there is only one common time"});
  }
}

std::string names_of(const HistoryFacts& m) {
  std::string text;
  for (const ControlFacts& c : m.controls) text += (text.empty() ? "" : ", ") + c.name;
  return text.empty() ? "none" : text;
}

}  // namespace

Section controls_section(const ComparedPair& pair, const CompareOptions& options, const RunControl& control) {
  Section section{.name = "controls", .title = "By control"};
  const std::vector<SharedControl> shared = shared_controls(pair.series_a.facts(), pair.series_b.facts());
  if (shared.empty())
    section.undefined = "no control is common to both (A: " + names_of(pair.series_a.facts()) +
                        "; B: " + names_of(pair.series_b.facts()) + ")";
  for (std::size_t k = 0; k < shared.size(); ++k) {
    const auto n = static_cast<double>(shared.size());
    add_control(pair, shared[k], options, control.part(static_cast<double>(k) / n, (static_cast<double>(k) + 1.0) / n),
                section);
  }
  return section;
}

}  // namespace patinate::analysis
