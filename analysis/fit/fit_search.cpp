#include "analysis/fit/fit_search.h"

#include <cmath>
#include <limits>

#include "analysis/fit/multi_start.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kLookPurpose = 1u << 20;  ///< Plus the evaluation's number.

/// The means over several seeds.
class AgedModel {
 public:
  AgedModel(const FitModel& model, const std::vector<double>& values, std::uint64_t seed_shift,
            const RunControl& control)
      : model_(model) {
    for (int r = 0; r < model.repeats; ++r) {
      const double n = model.repeats;
      composers_.push_back(
          model.age(values, seed_shift + static_cast<std::uint64_t>(r), control.part(r / n, (r + 1) / n)));
    }
  }

  [[nodiscard]] FitPoint compose(const std::vector<double>& values, const RunControl& control) const {
    return compose(values, *model_.objective, control);
  }

  [[nodiscard]] FitPoint compose(const std::vector<double>& values, const FitObjective& objective,
                                 const RunControl& control) const {
    FitPoint point{.values = values, .result = {}};
    for (const ComposeWith& compose : composers_) {
      ObjectiveValue v = objective(compose(values, control), control);
      if (point.result.figures.empty()) {
        point.result = std::move(v);
        continue;
      }
      const auto add = [](std::optional<double>& sum, const std::optional<double>& x) {
        sum = sum && x ? std::optional(*sum + *x) : std::nullopt;
      };
      add(point.result.objective, v.objective);
      for (std::size_t i = 0; i < v.figures.size(); ++i) add(point.result.figures[i], v.figures[i]);
      if (point.result.problem.empty()) point.result.problem = v.problem;
    }
    if (composers_.size() > 1) {
      const auto n = static_cast<double>(composers_.size());
      if (point.result.objective) *point.result.objective /= n;
      for (std::optional<double>& f : point.result.figures) {
        if (f) *f /= n;
      }
    }
    return point;
  }

 private:
  const FitModel& model_;
  std::vector<ComposeWith> composers_;
};

FitPoint undefined_point(const FitModel& model, const std::vector<double>& values, const std::string& problem) {
  return {values,
          {.objective = std::nullopt,
           .figures = std::vector<std::optional<double>>(model.objective->terms().size()),
           .problem = problem}};
}

RunControl silent(RunControl control) {
  control.on_progress = {};
  return control;
}

}  // namespace

std::vector<std::size_t> FitModel::indices(bool is_appearance) const {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].is_appearance == is_appearance) out.push_back(i);
  }
  return out;
}

FitEvaluation evaluate(const FitModel& model, const std::string& name, const std::vector<double>& values,
                       const AppearanceSearch& search, std::uint64_t seed_shift, const RunControl& control) try {
  FitEvaluation evaluation{.name = name, .points = {}};
  const AgedModel aged(model, values, seed_shift, control.part(0.0, search.num_appearance > 1 ? 0.6 : 0.95));
  evaluation.points.push_back(aged.compose(values, silent(control)));
  const std::vector<std::size_t> appearance = model.indices(true);
  if (appearance.empty() || search.num_appearance <= 1) return evaluation;
  std::vector<double> start;
  for (const std::size_t i : appearance) start.push_back(unit_at(model.parameters[i], values[i]));
  bool is_first = true;
  const auto f = [&](const std::vector<double>& unit) {
    if (!is_first) {
      std::vector<double> tried = values;
      for (std::size_t k = 0; k < appearance.size(); ++k)
        tried[appearance[k]] = value_at(model.parameters[appearance[k]], unit[k]);
      evaluation.points.push_back(aged.compose(tried, silent(control)));
      control.report(0.6 + 0.4 * static_cast<double>(evaluation.points.size()) /
                               static_cast<double>(search.num_appearance + 1));
    }
    is_first = false;  // The start itself has been looked at.
    return evaluation.points.back().result.objective.value_or(std::numeric_limits<double>::infinity());
  };
  const EvolutionOptions options{.step = search.step,
                                 .tolerance = model.tolerance,
                                 .flatness = model.flatness,
                                 .relative_flatness = model.relative_flatness,
                                 .seed = model.seed,
                                 .purpose = kLookPurpose + static_cast<std::uint32_t>(search.item)};
  evaluation.is_converged =
      minimize(f, start, search.num_appearance, {.search = options, .starts = search.starts}).is_converged;
  return evaluation;
} catch (const InputError& e) {
  return {.name = name, .points = {undefined_point(model, values, e.what())}};
}

FitEvaluation evaluate_appearances(const FitModel& model, const std::string& name,
                                   std::span<const std::vector<double>> values, std::uint64_t seed_shift,
                                   const RunControl& control) try {
  FitEvaluation evaluation{.name = name, .points = {}};
  if (values.empty()) return evaluation;
  const AgedModel aged(model, values.front(), seed_shift, control.part(0.0, 0.7));
  for (const std::vector<double>& v : values) evaluation.points.push_back(aged.compose(v, silent(control)));
  return evaluation;
} catch (const InputError& e) {
  FitEvaluation evaluation{.name = name, .points = {}};
  for (const std::vector<double>& v : values) evaluation.points.push_back(undefined_point(model, v, e.what()));
  return evaluation;
}

FitEvaluation draw_chance(const FitModel& model, const std::string& name, const std::vector<double>& values,
                          std::uint64_t draw, const RunControl& control) try {
  const std::uint64_t shift = static_cast<std::uint64_t>(model.repeats) - 1 + draw;
  const AgedSurface other = model.age(values, shift, control.part(0.0, 0.4))(values, silent(control));
  const AgedModel aged(model, values, 0, control.part(0.4, 0.95));
  const FitObjective captured = model.objective->with_captured(other, draw, silent(control));
  FitEvaluation evaluation{.name = name,
                           .points = {{.values = values, .result = (*model.objective)(other, silent(control))}},
                           .chance = aged.compose(values, captured, silent(control)).result.objective};
  if (model.held_out) evaluation.held_out = (*model.held_out)(other, silent(control)).objective;
  return evaluation;
} catch (const InputError& e) {
  return {.name = name, .points = {undefined_point(model, values, e.what())}};
}

}  // namespace patinate::analysis
