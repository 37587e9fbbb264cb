#include "analysis/fit/fit_search.h"

#include <cmath>
#include <limits>
#include <utility>

#include "analysis/fit/multi_start.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::uint32_t kLookPurpose = 1u << 20;          ///< Plus the evaluation's number.
constexpr std::uint64_t kDeviationsOfCapture = 1u << 24;  ///< Draws of one capture's deviations, apart from another's.

/// Mean of objectives, figure by figure; undefined where one of them is.
ObjectiveValue mean_objective(std::span<const ObjectiveValue> values) {
  ObjectiveValue mean = values.front();
  const auto add = [](std::optional<double>& sum, const std::optional<double>& x) {
    sum = sum && x ? std::optional(*sum + *x) : std::nullopt;
  };
  for (const ObjectiveValue& v : values.subspan(1)) {
    add(mean.objective, v.objective);
    for (std::size_t i = 0; i < v.figures.size(); ++i) add(mean.figures[i], v.figures[i]);
    if (mean.problem.empty()) mean.problem = v.problem;
  }
  const auto n = static_cast<double>(values.size());
  if (mean.objective) *mean.objective /= n;
  for (std::optional<double>& f : mean.figures) {
    if (f) *f /= n;
  }
  return mean;
}

/// @param of_captures  One a capture.
FitPoint point_of(const FitModel& model, const std::vector<double>& values, std::vector<ObjectiveValue> of_captures) {
  FitPoint point{.values = values, .result = {}};
  if (of_captures.size() > 1) {
    for (std::size_t c = 0; c < of_captures.size(); ++c) {
      ObjectiveValue& v = of_captures[c];
      point.captures.push_back(v.objective);
      if (!v.problem.empty()) v.problem = model.captures[c].name + ": " + v.problem;
    }
  }
  point.result = mean_objective(of_captures);
  return point;
}

/// Aged models: of every capture and several seeds.
class AgedModel {
 public:
  AgedModel(const FitModel& model, const std::vector<double>& values, std::uint64_t seed_shift,
            const RunControl& control)
      : model_(model), composers_(model.captures.size()) {
    const double n = static_cast<double>(model.captures.size()) * model.repeats;
    double done = 0.0;
    for (std::size_t c = 0; c < model.captures.size(); ++c) {
      for (int r = 0; r < model.repeats; ++r, done += 1.0)
        composers_[c].push_back(model.captures[c].age(model.values_of(c, values),
                                                      seed_shift + static_cast<std::uint64_t>(r),
                                                      control.part(done / n, (done + 1.0) / n)));
    }
  }

  [[nodiscard]] FitPoint compose(const std::vector<double>& values, const RunControl& control) const {
    std::vector<const FitObjective*> objectives;
    for (const FitModel::Capture& c : model_.captures) objectives.push_back(c.objective);
    return compose(values, objectives, control);
  }

  /// Means over the seeds. @param objectives  One a capture.
  [[nodiscard]] FitPoint compose(const std::vector<double>& values, std::span<const FitObjective* const> objectives,
                                 const RunControl& control) const {
    std::vector<ObjectiveValue> of_captures;
    for (std::size_t c = 0; c < composers_.size(); ++c) {
      std::vector<ObjectiveValue> of_seeds;
      for (const ComposeWith& compose : composers_[c])
        of_seeds.push_back((*objectives[c])(compose(model_.values_of(c, values), control), control));
      of_captures.push_back(mean_objective(of_seeds));
    }
    return point_of(model_, values, std::move(of_captures));
  }

 private:
  const FitModel& model_;
  std::vector<std::vector<ComposeWith>> composers_;  ///< [capture][seed]
};

FitPoint undefined_point(const FitModel& model, const std::vector<double>& values, const std::string& problem) {
  return {values,
          {.objective = std::nullopt,
           .figures = std::vector<std::optional<double>>(model.captures.front().objective->terms().size()),
           .problem = problem}};
}

}  // namespace

std::vector<std::size_t> FitModel::indices(bool is_appearance) const {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].is_appearance == is_appearance) out.push_back(i);
  }
  return out;
}

std::vector<double> FitModel::values_of(std::size_t capture, const std::vector<double>& all) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].capture.value_or(capture) == capture) values.push_back(all[i]);
  }
  return values;
}

FitEvaluation evaluate(const FitModel& model, const std::string& name, const std::vector<double>& values,
                       const AppearanceSearch& search, std::uint64_t seed_shift, const RunControl& control) try {
  FitEvaluation evaluation{.name = name, .points = {}};
  const AgedModel aged(model, values, seed_shift, control.part(0.0, search.num_appearance > 1 ? 0.6 : 0.95));
  evaluation.points.push_back(aged.compose(values, control.silent()));
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
      evaluation.points.push_back(aged.compose(tried, control.silent()));
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
  for (const std::vector<double>& v : values) evaluation.points.push_back(aged.compose(v, control.silent()));
  return evaluation;
} catch (const InputError& e) {
  FitEvaluation evaluation{.name = name, .points = {}};
  for (const std::vector<double>& v : values) evaluation.points.push_back(undefined_point(model, v, e.what()));
  return evaluation;
}

FitEvaluation draw_chance(const FitModel& model, const std::string& name, const std::vector<double>& values,
                          std::uint64_t draw, const RunControl& control) try {
  const std::uint64_t shift = static_cast<std::uint64_t>(model.repeats) - 1 + draw;
  const auto n = static_cast<double>(model.captures.size());
  std::vector<FitObjective> captured;
  std::vector<ObjectiveValue> seen, held_out;
  for (std::size_t c = 0; c < model.captures.size(); ++c) {
    const FitModel::Capture& capture = model.captures[c];
    const std::vector<double> own = model.values_of(c, values);
    const auto at = static_cast<double>(c);
    const AgedSurface other =
        capture.age(own, shift, control.part(0.4 * at / n, 0.4 * (at + 1.0) / n))(own, control.silent());
    seen.push_back((*capture.objective)(other, control.silent()));
    if (capture.held_out) held_out.push_back((*capture.held_out)(other, control.silent()));
    captured.push_back(capture.objective->with_captured(other, draw + c * kDeviationsOfCapture, control.silent()));
  }
  std::vector<const FitObjective*> objectives;
  for (const FitObjective& o : captured) objectives.push_back(&o);
  const AgedModel aged(model, values, 0, control.part(0.4, 0.95));
  FitEvaluation evaluation{.name = name,
                           .points = {point_of(model, values, std::move(seen))},
                           .chance = aged.compose(values, objectives, control.silent()).result.objective};
  if (!held_out.empty()) evaluation.held_out = mean_objective(held_out).objective;
  return evaluation;
} catch (const InputError& e) {
  return {.name = name, .points = {undefined_point(model, values, e.what())}};
}

}  // namespace patinate::analysis
