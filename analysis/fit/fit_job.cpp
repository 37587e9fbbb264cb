#include "analysis/fit/fit_job.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/fit/chance.h"
#include "analysis/fit/fit_outcome.h"
#include "analysis/fit/fit_search.h"
#include "analysis/fit/fit_work.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kSearchVersion = 4;     ///< Raised when the same input gives other values;
constexpr std::int64_t kStageVersion = 8;      ///< when the same values give another report.
constexpr int kEvaluationsPerParameter = 100;  ///< Default budget (docs/fit.md).
constexpr std::size_t kMinParameters = 2;    ///< Least parameters that a budget counts: one alone does not end in 100.
constexpr double kSmallestLookStep = 0.05;   ///< Step of the search for an appearance, however narrow the outer one has
                                             ///< become; but no wider than its first step.
constexpr double kScanAppearanceStep = 0.1;  ///< Step of the search for an appearance beside the best.
constexpr std::uint64_t kScanItems = 1u << 18;  ///< Random numbers of scans, apart from those of the search.
constexpr std::uint64_t kMaxScanPlaces = 64;
constexpr double kNearTheLimit = 1.25;  ///< In multiples of the objective that cannot be told from the best.

using MakeRecord = std::function<FitEvaluation(const fs::path& folder, const RunControl& control)>;

JobItem record_item(const std::string& name, int stage, const std::string& key, MakeRecord make) {
  return {.name = name,
          .outputs = {fit_record_file(name)},
          .run =
              [name, make = std::move(make)](const fs::path& folder, const RunControl& control) {
                save_json(folder / fit_record_file(name), evaluation_json(make(folder, control)));
              },
          .key = key,
          .stage = stage};
}

FitEvaluation evaluate_candidate(const std::shared_ptr<FitWork>& work, const std::string& name, int generation, int k,
                                 const fs::path& folder, const RunControl& control) {
  const FitWork::Standing standing = work->standing(folder, generation);
  if (standing.search.is_done()) return {.name = name, .points = {}, .is_skipped = true};
  std::vector<double> values = standing.values_for(k);
  const std::vector<double> unit = standing.search.candidate(k);
  for (std::size_t i = 0; i < work->aged.size(); ++i)
    values[work->aged[i]] = value_at(work->task.parameters[work->aged[i]], unit[i]);
  const AppearanceSearch search{
      .num_appearance = work->appearance.empty() ? 1 : work->task.options.appearance_evaluations,
      .step = std::min(std::max(standing.search.spread(), kSmallestLookStep), work->task.options.step),
      .item = static_cast<std::uint64_t>(1 + generation * work->budget.population + k)};
  return evaluate(work->ready(control), name, values, search, 0, control);
}

/// The parameter at one of its places: the others held, their appearance searched again, and the others moved along the
/// valley.
FitEvaluation scan_place(FitWork& work, const std::string& name, std::size_t i, std::size_t k, const fs::path& folder,
                         const RunControl& control) {
  const std::vector<double> best = work.best(folder).values;
  const std::vector<std::vector<double>> places = work.scan_values(best, i);
  if (k >= places.size()) return {.name = name, .points = {}, .is_skipped = true};
  const std::vector<double>& held = places[k];
  const FitModel& model = work.ready(control);
  AppearanceSearch search{.num_appearance = work.appearance.empty() ? 1 : work.task.options.appearance_evaluations,
                          .step = kScanAppearanceStep,
                          .item = kScanItems + i * kMaxScanPlaces + k};
  FitEvaluation evaluation = evaluate(model, name, held, search, 0, control.part(0.0, 0.4));
  const std::optional<std::size_t> found = evaluation.best();
  const std::vector<double> draws = work.chances(folder);
  // Chance over the range, not only at the best: of places that can be told from it only just or not at all.
  if (found && !draws.empty() &&
      *evaluation.points[*found].result.objective <=
          kNearTheLimit * untellable_objective(*work.best(folder).result.objective, draws,
                                               static_cast<int>(work.task.parameters.size()))) {
    const std::uint64_t draw = draws.size() + 1 + i * kMaxScanPlaces + k;
    evaluation.chance = draw_chance(model, name, evaluation.points[*found].values, draw, control.part(0.4, 0.6)).chance;
  }
  const FitWork::Ground& ground = work.ground(folder);
  if (!ground.valley) return evaluation;
  std::vector<double> moved = held;
  const double way = unit_at(work.task.parameters[i], held[i]) - unit_at(work.task.parameters[i], best[i]);
  bool is_moved = false;
  for (std::size_t j = 0; j < moved.size(); ++j) {
    if (j == i) continue;
    const FitParameter& p = work.task.parameters[j];
    moved[j] = value_at(p, std::clamp(unit_at(p, best[j]) + way * ground.valley->slopes[i][j], 0.0, 1.0));
    is_moved = is_moved || (!p.is_appearance && moved[j] != held[j]);
  }
  if (!is_moved) return evaluation;
  search.item += kScanItems;
  const FitEvaluation along = evaluate(model, name, moved, search, 0, control.part(0.6, 1.0));
  evaluation.points.insert(evaluation.points.end(), along.points.begin(), along.points.end());
  return evaluation;
}

/// Items after the search: the best with other seeds, and then along every parameter.
void add_scans(const std::shared_ptr<FitWork>& work, int seeds_stage, JobPlan& plan) {
  const int stage = seeds_stage + 1;
  const FitOptions& options = work->task.options;
  for (int s = 1; s <= options.seeds; ++s) {
    plan.items.push_back(record_item(
        "seed-" + std::to_string(s), seeds_stage, "", [work, s](const fs::path& folder, const RunControl& control) {
          return draw_chance(work->ready(control), "seed-" + std::to_string(s), work->best(folder).values,
                             static_cast<std::uint64_t>(s), control);
        }));
  }
  for (const std::size_t i : work->aged) {
    for (int k = 0; k < options.scan; ++k) {
      const std::string name = "scan-" + std::to_string(i) + "-" + std::to_string(k);
      plan.items.push_back(
          record_item(name, stage, "", [work, i, k, name](const fs::path& folder, const RunControl& control) {
            return scan_place(*work, name, i, static_cast<std::size_t>(k), folder, control);
          }));
    }
  }
  if (work->appearance.empty() || options.scan == 0) return;
  plan.items.push_back(
      record_item("scan-appearance", stage, "", [work](const fs::path& folder, const RunControl& control) {
        std::vector<std::vector<double>> all;
        for (const std::size_t i : work->appearance) {
          for (std::vector<double>& values : work->scan_values(work->best(folder).values, i))
            all.push_back(std::move(values));
        }
        return evaluate_appearances(work->ready(control), "scan-appearance", all, 0, control);
      }));
}

/// Says what is wrong with them before work starts.
std::vector<SeriesFile> checked_captures(const FitTask& task) {
  std::vector<SeriesFile> files;
  for (const FitCapture& c : task.captures) {
    files.push_back(open_series(c.history));
    const TextureSeries& series = files.back().series;
    const TextureSeries& first = files.front().series;
    if (task.objective.until && series.facts().time_unit != first.facts().time_unit)
      throw InvalidInput("--until: " + task.captures.front().name + " counts time in " +
                         std::string(time_unit_text(first.facts().time_unit)) + ", " + c.name + " in " +
                         std::string(time_unit_text(series.facts().time_unit)));
    (void)FitObjective(series, c.outline, task.terms, task.objective);
    if (task.objective.until) (void)FitObjective(series, c.outline, task.terms, task.objective, FitFrames::HeldOut);
  }
  return files;
}

void add_search_inputs(const FitTask& task, const std::vector<SeriesFile>& series, JobInputs& inputs) {
  for (std::size_t c = 0; c < series.size(); ++c)
    inputs.add_content("history", series.size() == 1 ? "HISTORY" : task.captures[c].name, series[c].key());
  task.add_inputs(inputs);
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    const FitParameter& p = task.parameters[i];
    inputs.add_value((p.capture ? "--own " : "--vary ") + column_of(task, i),
                     number_text(p.range.low) + ":" + number_text(p.range.high) + ":" +
                         std::string(kFitScaleNames[static_cast<std::size_t>(p.range.scale)]));
  }
  for (const FitTerm& t : task.terms)
    inputs.add_value("--objective " + std::string(kFitFigureNames[static_cast<std::size_t>(t.figure)]),
                     number_text(t.weight));
  inputs.add_options(option_values(task.objective));
  inputs.add_value("--seed", std::to_string(task.seed));
}

}  // namespace

fs::path held_out_picture(const fs::path& fit, std::size_t num_captures, const char* stem, std::size_t capture) {
  return fit / kHeldOutFolder / (file_of_capture(num_captures, stem, capture) + ".png");
}

std::string file_of_capture(std::size_t num_captures, const std::string& stem, std::size_t capture) {
  return num_captures == 1 ? stem : stem + "_" + std::to_string(capture + 1);
}

std::string column_of(const FitTask& task, std::size_t parameter) {
  const FitParameter& p = task.parameters[parameter];
  return p.range.name + (p.capture ? " (" + task.captures[*p.capture].name + ")" : "");
}

void describe(OptionVisitor& v, FitOptions& o) {
  v.visit({"evaluations", "Budget of the search; 0 = 100 for each parameter that is searched, at least 200", "",
           between(0, 1e6)},
          o.evaluations);
  v.visit({"appearance_evaluations",
           "Largest number of appearances tried for each simulation, if some parameters change only the appearance", "",
           between(1, 1e5)},
          o.appearance_evaluations);
  v.visit({"repeats", "Seeds over which the objective is averaged", "", between(1, 100)}, o.repeats);
  v.visit({"population", "Candidates a generation, >= 4; 0 = by the number of parameters", "", between(0, 1000)},
          o.population);
  v.visit({"step",
           "First standard deviation of candidates, share of a range",
           "",
           {.low = 0, .high = 1, .is_low_open = true}},
          o.step);
  v.visit({"tolerance",
           "Stop when the candidates' spread is below this share of every range",
           "",
           {.low = 0, .high = 1, .is_low_open = true}},
          o.tolerance);
  v.visit({"starts", "Largest number of local minima that the search follows; 1 = only from the scene's own values", "",
           between(1, 100)},
          o.starts);
  v.visit({"scan", "Evaluations for each parameter, to find which values the data determine", "",
           between(0, static_cast<double>(kMaxScanPlaces))},
          o.scan);
  v.visit({"seeds", "Further simulations of the best values with other seeds, to measure chance", "", between(0, 100)},
          o.seeds);
}

FitBudget fit_budget(const FitOptions& options, std::size_t num_aged, std::size_t num_appearance) {
  const std::size_t n = num_aged > 0 ? num_aged : num_appearance;
  FitBudget budget;
  budget.population = Evolution::population_of(std::max<std::size_t>(n, 1), {.population = options.population});
  budget.least = 1 + 2 * budget.population;
  budget.evaluations =
      options.evaluations > 0
          ? options.evaluations
          : std::max(budget.least, 1 + kEvaluationsPerParameter * static_cast<int>(std::max(n, kMinParameters)));
  return budget;
}

std::string budget_problem(const FitBudget& budget) {
  return "--evaluations: found " + std::to_string(budget.evaluations) + "; expected at least " +
         std::to_string(budget.least) + ", the start and two generations of " + std::to_string(budget.population);
}

JobPlan plan_fit(FitTask task, const fs::path& output) {
  check_ranges(task.options);
  for (const FitParameter& p : task.parameters) {
    if (const std::string problem = start_problem(p); !problem.empty()) throw InvalidInput(problem);
  }
  const std::vector<SeriesFile> series = checked_captures(task);
  JobInputs search_inputs("fit search", kSearchVersion), inputs("fit", kStageVersion);
  add_search_inputs(task, series, search_inputs);
  add_search_inputs(task, series, inputs);
  const auto work = std::make_shared<FitWork>(std::move(task));
  if (work->budget.evaluations < work->budget.least) {
    throw InvalidInput("fit: a budget of " + std::to_string(work->budget.evaluations) +
                       " evaluations is too small; use at least " + std::to_string(work->budget.least));
  }
  for (const auto& [name, value] : option_values(work->task.options)) {
    const bool is_of_search = name != "evaluations" && name != "scan" && name != "seeds";
    if (is_of_search || work->aged.empty()) search_inputs.add_value(dashed(name), value);
    inputs.add_value(dashed(name), value);
  }
  JobPlan plan = inputs.plan(output, kFitReportFile);
  const std::string search_key = search_inputs.key();
  plan.items.push_back(record_item("initial", 0, search_key, [work](const fs::path&, const RunControl& control) {
    const int num_appearance = work->appearance.empty() ? 1
                               : work->aged.empty()     ? work->budget.evaluations
                                                        : work->task.options.appearance_evaluations;
    return evaluate(work->ready(control), "initial", work->start,
                    {.num_appearance = num_appearance,
                     .step = work->task.options.step,
                     .starts = work->aged.empty() ? work->task.options.starts : 1,
                     .item = 0},
                    0, control);
  }));
  for (int g = 0; g < work->num_generations(); ++g) {
    for (int k = 0; k < work->budget.population; ++k) {
      const std::string name = work->candidate_name(g, k);
      plan.items.push_back(
          record_item(name, 1 + g, search_key, [work, name, g, k](const fs::path& folder, const RunControl& control) {
            return evaluate_candidate(work, name, g, k, folder, control);
          }));
    }
  }
  add_scans(work, 1 + work->num_generations(), plan);
  plan.join = [work, key = plan.key](const fs::path& folder, const RunControl& control) {
    join_fit(*work, folder, key, control);
  };
  return plan;
}

}  // namespace patinate::analysis
