#include "tools/patinate/study/study_fit.h"

#include <set>

#include "analysis/fit/fit_job.h"
#include "analysis/fit/fit_objective.h"
#include "analysis/fit/fit_parameter.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/services/fit_scene.h"

namespace patinate::cli {

namespace {

constexpr std::size_t kMostRanges = 100;

std::vector<analysis::FitRange> read_ranges(const JsonReader& list, StudyContext& context) {
  std::vector<analysis::FitRange> ranges;
  for (const JsonReader& range : list.elements(kMostRanges))
    context.attempt([&] {
      ranges.push_back(analysis::read_fit_range(range));
      if (ranges.back().is_own) range.fail("a range without `own`; fits of a study have one history each");
    });
  if (list.elements(kMostRanges).empty()) list.fail("at least one range");
  return ranges;
}

std::vector<std::string> objective_words(JsonReader objective, StudyContext& context) {
  std::vector<std::string> words;
  for (const std::string& name : objective.keys()) {
    const JsonReader weight = objective.member(name);
    try {
      (void)analysis::parse_fit_term(name);
      words.insert(words.end(), {"--objective", name + "=" + number_text(weight.number(above(0)))});
    } catch (const InputError& e) {
      context.problem(weight, e.what());
    }
  }
  return words;
}

}  // namespace

FitWords read_fit_words(JsonReader& part, const std::vector<std::filesystem::path>& scenes, StudyContext& context) {
  const JsonReader vary = part.member("vary");
  const std::vector<analysis::FitRange> ranges = read_ranges(vary, context);
  FitWords fit;
  std::vector<std::string>& words = fit.words;
  for (const analysis::FitRange& r : ranges) {
    const std::string scale = r.scale == analysis::FitScale::Log ? ":log" : "";
    words.insert(words.end(), {"--vary", r.name + "=" + number_text(r.low) + ":" + number_text(r.high) + scale});
  }
  if (part.has("objective")) {
    for (std::string& word : objective_words(part.member("objective"), context)) words.push_back(std::move(word));
  }
  if (context.has_problems()) return fit;  // A scene that is not there has no numbers.
  for (const std::filesystem::path& scene : scenes) {
    context.attempt([&] {
      const FitScene read(scene, ranges, {}, {});
      fit.num_aged = fit.num_appearance = 0;  // The same in all: they go by the pointers.
      for (const analysis::FitParameter& p : read.parameters()) {
        if (const std::string problem = analysis::start_problem(p); !problem.empty())
          context.problem(vary, scene.string() + ": " + problem);
        ++(p.is_appearance ? fit.num_appearance : fit.num_aged);
      }
    });
  }
  return fit;
}

void check_fit_budgets(const JsonReader& part, const FitWords& fit, const std::vector<StudyCell>& cells,
                       StudyContext& context) {
  std::set<std::string> told;
  for (const StudyCell& cell : cells) {
    analysis::FitOptions options;
    const std::vector<std::string>& words = cell.words.front();
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
      if (words[i] == "--evaluations") options.evaluations = std::stoi(words[i + 1]);
      if (words[i] == "--population") options.population = std::stoi(words[i + 1]);
    }
    const analysis::FitBudget budget = analysis::fit_budget(options, fit.num_aged, fit.num_appearance);
    if (budget.evaluations < budget.least) told.insert(analysis::budget_problem(budget));
  }
  for (const std::string& problem : told) context.problem(part, problem);
}

}  // namespace patinate::cli
