#include <nlohmann/json.hpp>

#include "analysis/fit/fit_job.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/repeating_command.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/fit_scene.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// What is varied and fitted, as given.
struct Wanted {
  std::vector<analysis::FitRange> ranges;
  std::vector<analysis::FitTerm> terms;
};

void read_parameters(const fs::path& path, Wanted& wanted) {
  const Json root = load_json(path);
  JsonReader json(path.string(), root);
  json.expect_format("patinate.parameters", 1);
  const JsonReader vary = json.member("vary");
  for (const JsonReader& range : vary.elements(100)) wanted.ranges.push_back(analysis::read_fit_range(range));
  if (wanted.ranges.empty()) vary.fail("at least one range");
  if (json.has("objective")) {
    JsonReader objective = json.member("objective");
    for (const std::string& name : objective.keys()) {
      const JsonReader weight = objective.member(name);
      try {
        wanted.terms.push_back(analysis::parse_fit_term(name));
      } catch (const ParseError& e) {
        throw IoError(path.string(), weight.pointer() + ": " + e.what());
      }
      wanted.terms.back().weight = weight.number(above(0));
    }
  }
  json.finish();
}

/// What repeats it: options that are not the default, and nothing that changes no byte.
std::string command_of(const fs::path& scene, const fs::path& history, const fs::path& parameters,
                       const std::vector<std::string>& vary, const std::vector<std::string>& objective,
                       const analysis::FitTask& task) {
  std::string text = "patinate fit " + input_word(scene) + " " + input_word(history);
  for (const std::string& word : vary) text += " --vary " + shell_word(word);
  if (!parameters.empty()) text += " --parameters " + input_word(parameters);
  for (const std::string& word : objective) text += " --objective " + shell_word(word);
  text += changed_options(option_values(task.objective), option_values(analysis::ObjectiveOptions{})) +
          changed_options(option_values(task.options), option_values(analysis::FitOptions{}));
  if (task.seed != static_cast<std::uint64_t>(CommonOptions{}.seed)) text += " --seed " + std::to_string(task.seed);
  return text + kAnyOutput;
}

}  // namespace

int cmd_fit(CommandRun& run) {
  analysis::FitTask task;
  fs::path scene_path, history, parameters, output;
  std::vector<std::string> vary, objective;
  bool require_converged = false;
  run.line.positional("SCENE", "A scene file with the starting values", scene_path);
  run.line.positional("HISTORY", "What it should come close to: a history, or a transfer", history);
  run.line.output("FOLDER", "Folder to make: scene.json, report.html, report.json, evaluations.csv, before, after",
                  output);
  run.line.repeated("vary", "POINTER=LOW:HIGH[:log]", "A number of the scene, by its JSON pointer, and its range",
                    vary);
  run.line.option("parameters", "FILE", "Ranges and figures from a JSON file (docs/fit.md)", parameters);
  run.line.repeated("objective", "FIGURE[=WEIGHT]", "What to bring near 0; default: color_distribution", objective);
  run.line.suggestions({analysis::kFitFigureNames.begin(), analysis::kFitFigureNames.end()});
  run.line.options(task.objective);
  run.line.options(task.options);
  run.line.flag("require-converged", "Exit with 1 where the budget ended the search; the folder is made all the same",
                require_converged);
  run.line.list("Figures",
                {{"color_distribution", "distance between the distributions of color, mean over times"},
                 {"mean_color", "distance between the mean colors, root mean square over times"},
                 {"covered", "share of places that have changed visibly, mean difference over times, %"},
                 {"onset, saturation", "when places have made a tenth, nine tenths of their change, % of the span"},
                 {"color_by_control", "distance between the colors given control and time"},
                 {"rate_by_control", "change over the span by control"},
                 {"ciede2000", "place by place, where the history lies on the scene's atlas"}});
  run.line.example(
      "fit plate.json copper --vary /rules/0/rate=0.01:1:log --vary /appearance/patina/strength=0.2:3 --clock span -o "
      "copper_fit");
  run.line.example(
      "fit plate.json copper --vary /emitters/0/carries/water=0.1:2:log --objective covered --objective mean_color=0.5 "
      "--evaluations 200 -o copper_fit");
  if (!run.parse()) return 0;

  Wanted wanted;
  if (!parameters.empty()) read_parameters(parameters, wanted);
  for (const std::string& text : vary) wanted.ranges.push_back(analysis::parse_fit_range(text));
  if (!objective.empty()) wanted.terms.clear();
  for (const std::string& text : objective) wanted.terms.push_back(analysis::parse_fit_term(text));
  for (std::size_t i = 0; i < wanted.terms.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (wanted.terms[i].figure == wanted.terms[k].figure)
        throw UsageError(
            "--objective: " + std::string(analysis::kFitFigureNames[static_cast<std::size_t>(wanted.terms[i].figure)]) +
            " is given twice");
    }
  }
  if (wanted.terms.empty()) wanted.terms.emplace_back();
  if (wanted.ranges.empty())
    throw UsageError("--vary: nothing may vary; give at least one POINTER=LOW:HIGH, such as /rules/0/rate=0.01:1:log");
  const fs::path given_history = history;
  history = history_place(history);
  const PathKind kind = kind_of(history);
  if (kind != PathKind::History && kind != PathKind::Transfer)
    throw InvalidInput(history.string() + ": is no history or transfer; only those age");
  std::vector<std::string> controls;
  const analysis::TextureSeries series = analysis::open_series(history).series;
  for (const ControlFacts& c : series.facts().controls) controls.push_back(c.name);

  const FitScene scene(scene_path, wanted.ranges, controls, run.control("scene"));
  for (const std::string& note : scene.notes()) run.note(note);
  task.history = history;
  task.model_name = scene.outline().name;
  task.parameters = scene.parameters();
  task.outline = scene.outline();
  task.age = scene.age();
  task.aging_seconds = scene.aging_seconds();
  task.terms = wanted.terms;
  task.seed = static_cast<std::uint64_t>(run.line.common().seed);
  task.add_inputs = [scene](JobInputs& inputs) { scene.add_inputs(inputs); };
  task.write_model = [scene, output](const fs::path& folder, const std::vector<double>& values) {
    scene.write(folder, output, values);
  };
  task.command = command_of(scene_path, given_history, parameters, vary, objective, task);
  const auto num_appearance = static_cast<std::size_t>(std::count_if(
      task.parameters.begin(), task.parameters.end(), [](const analysis::FitParameter& p) { return p.is_appearance; }));
  const analysis::FitBudget budget =
      analysis::fit_budget(task.options, task.parameters.size() - num_appearance, num_appearance);
  if (budget.evaluations < budget.least) throw UsageError(analysis::budget_problem(budget));
  const std::optional<JobStatus> status = run.make_folder(analysis::plan_fit(std::move(task), output), "fit");
  if (!status) return 0;
  const Json report = load_json(output / analysis::kFitReportFile);
  const auto text = [](const Json& v) {
    return v.is_null() ? std::string("undefined") : short_number_text(rounded(v.get<double>(), 4));
  };
  run.note("objective: " + text(report.at("objective").at("before")) + " before, " +
           text(report.at("objective").at("after")) + " after");
  if (const Json& held_out = report.at("held_out"); !held_out.is_null())
    run.note("frames after " + text(held_out.at("until")) + ", which were not seen: " + text(held_out.at("before")) +
             " before, " + text(held_out.at("after")) +
             " after; the last frame seen, held: " + text(held_out.at("last_frame")));
  for (const Json& p : report.at("parameters"))
    run.note(p.at("name").get<std::string>() + ": " + text(p.at("initial")) + " -> " + text(p.at("best")) + "; " +
             p.at("verdict").get<std::string>());
  const bool is_converged = report.at("evaluations").at("converged").get<bool>();
  const std::string not_converged = "not converged: " + std::to_string(budget.evaluations) +
                                    " evaluations ended the search; a larger --evaluations resumes from here";
  if (!is_converged && !require_converged) run.note(not_converged);
  run.report_output(*status, output,
                    Json{{"objective", report.at("objective")},
                         {"held_out", report.at("held_out")},
                         {"parameters", report.at("parameters")},
                         {"evaluations", report.at("evaluations")}});
  if (!is_converged && require_converged) throw CannotComplete(output.string() + ": " + not_converged);
  return 0;
}

}  // namespace patinate::cli
