#include "analysis/fit/fit_work.h"

#include <cstdint>
#include <utility>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr double kFlatness = 1e-2;          ///< Delta E or per cent: smaller differences are not searched for.
constexpr double kRelativeFlatness = 0.01;  ///< Nor are such shares of the objective.

}  // namespace

fs::path fit_record_file(const std::string& name) { return fs::path("evaluations") / (name + ".json"); }

FitWork::FitWork(FitTask given) : task(std::move(given)) {
  model.parameters = task.parameters;
  for (const FitCapture& c : task.captures) model.captures.push_back({.name = c.name, .age = c.age});
  model.repeats = task.options.repeats;
  model.flatness = kFlatness;
  model.relative_flatness = kRelativeFlatness;
  model.tolerance = task.options.tolerance;
  model.seed = task.seed;
  aged = model.indices(false);
  appearance = model.indices(true);
  budget = fit_budget(task.options, aged.size(), appearance.size());
  for (const FitParameter& p : task.parameters) start.push_back(p.start);
}

const FitModel& FitWork::ready(const RunControl& control) {
  const std::scoped_lock lock(mutex_);
  if (!objectives_.empty()) return model;
  // All before any is pointed to: the lists move.
  std::vector<FitObjective> objectives, held_out;
  for (const FitCapture& c : task.captures) {
    const SeriesFile series = open_series(c.history);
    objectives.emplace_back(series.series, c.outline, task.terms, task.objective, FitFrames::Seen, control);
    if (task.objective.until)
      held_out.emplace_back(series.series, c.outline, task.terms, task.objective, FitFrames::HeldOut, control);
  }
  objectives_ = std::move(objectives);
  held_out_ = std::move(held_out);
  for (std::size_t c = 0; c < task.captures.size(); ++c) {
    model.captures[c].objective = &objectives_[c];
    if (!held_out_.empty()) model.captures[c].held_out = &held_out_[c];
  }
  return model;
}

std::string FitWork::candidate_name(int generation, int k) const {
  return "evaluation-" + zero_padded(static_cast<std::uint64_t>(1 + generation * budget.population + k), 5);
}

FitEvaluation FitWork::record(const fs::path& folder, const std::string& name) {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = records_.find(name); found != records_.end()) return found->second;
  }
  FitEvaluation e = read_evaluation(folder / fit_record_file(name), task.parameters.size(), task.terms.size());
  const std::scoped_lock lock(mutex_);
  return records_.try_emplace(name, std::move(e)).first->second;
}

const std::vector<double>& FitWork::Standing::values_for(int k) const {
  const auto found = best.find(search.origin(k));
  return found != best.end() ? found->second.values : best.at(0).values;
}

FitWork::Standing FitWork::standing(const fs::path& folder, int generation) {
  const std::scoped_lock lock(search_mutex_);
  if (!search_) {
    std::vector<double> unit;
    for (const std::size_t i : aged) unit.push_back(unit_at(task.parameters[i], start[i]));
    const FitEvaluation initial = record(folder, "initial");
    const std::optional<std::size_t> i = initial.best();
    const double value = i ? *initial.points[*i].result.objective : std::numeric_limits<double>::infinity();
    search_ = Standing{.search = MultiStart(unit, value,
                                            {.search = {.population = budget.population,
                                                        .step = task.options.step,
                                                        .tolerance = task.options.tolerance,
                                                        .flatness = model.flatness,
                                                        .relative_flatness = model.relative_flatness,
                                                        .seed = task.seed},
                                             .starts = task.options.starts}),
                       .best = {{0, {.values = start}}}};
    (void)keep(initial, 0);
  }
  MultiStart& search = search_->search;
  while (search.generation() < generation && !search.is_done()) {
    std::vector<double> values;
    const int g = search.generation();
    for (int k = 0; k < budget.population; ++k)
      values.push_back(keep(record(folder, candidate_name(g, k)), search.origin(k)));
    search.tell(values);
  }
  return *search_;
}

std::vector<FitEvaluation> FitWork::searched(const fs::path& folder) {
  std::vector<FitEvaluation> list{record(folder, "initial")};
  for (int g = 0; g < num_generations(); ++g) {
    for (int k = 0; k < budget.population; ++k) list.push_back(record(folder, candidate_name(g, k)));
  }
  return list;
}

FitPoint FitWork::best(const fs::path& folder) {
  std::optional<FitPoint> best;
  for (const FitEvaluation& e : searched(folder)) {
    const std::optional<std::size_t> i = e.best();
    if (i && (!best || *e.points[*i].result.objective < *best->result.objective)) best = e.points[*i];
  }
  if (!best)
    throw InvalidInput("fit: no values give a surface that can be compared: " +
                       record(folder, "initial").points.front().result.problem);
  return *best;
}

std::vector<double> FitWork::chances(const fs::path& folder) {
  std::vector<double> draws;
  for (int s = 1; s <= task.options.seeds; ++s) {
    if (const std::optional<double> chance = record(folder, "seed-" + std::to_string(s)).chance)
      draws.push_back(*chance);
  }
  return draws;
}

std::vector<std::vector<double>> FitWork::scan_values(const std::vector<double>& best, std::size_t i) const {
  std::vector<std::vector<double>> list;
  for (const double place : scan_places(unit_at(task.parameters[i], best[i]), task.options.scan)) {
    std::vector<double> values = best;
    values[i] = value_at(task.parameters[i], place);
    list.push_back(std::move(values));
  }
  return list;
}

BoxPoint FitWork::box_point(const FitPoint& p) const {
  BoxPoint out{.at = {}, .objective = p.result.objective.value_or(std::numeric_limits<double>::infinity())};
  for (std::size_t i = 0; i < p.values.size(); ++i) out.at.push_back(unit_at(task.parameters[i], p.values[i]));
  return out;
}

const FitWork::Ground& FitWork::ground(const fs::path& folder) {
  const BoxPoint at = box_point(best(folder));
  const std::vector<FitEvaluation> list = searched(folder);
  const std::scoped_lock lock(search_mutex_);
  if (ground_) return *ground_;
  ground_.emplace();
  for (const FitEvaluation& e : list) {
    for (const FitPoint& p : e.points) ground_->tried.push_back(box_point(p));
  }
  ground_->valley = valley_of(at, ground_->tried, ground_->no_valley);
  return *ground_;
}

double FitWork::keep(const FitEvaluation& e, std::size_t origin) {
  const std::optional<std::size_t> i = e.best();
  if (!i) return std::numeric_limits<double>::infinity();
  const double value = *e.points[*i].result.objective;
  Standing::Best& best = search_->best[origin];
  if (value < best.value) best = {value, e.points[*i].values};
  return value;
}

}  // namespace patinate::analysis
