#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/fit/fit_job.h"
#include "app/fit/fit_captures.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "app/request/usage_error.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Parameters that are varied and fitted, as given.
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

/// Options as given on the command line.
struct Given {
  fs::path scene, parameters, output;
  std::vector<fs::path> histories;
  std::vector<std::string> vary, own, scene_of, objective;
};

Wanted wanted_of(const Given& given) {
  Wanted wanted;
  if (!given.parameters.empty()) read_parameters(given.parameters, wanted);
  for (const std::string& text : given.vary) wanted.ranges.push_back(analysis::parse_fit_range(text));
  for (const std::string& text : given.own) {
    wanted.ranges.push_back(analysis::parse_fit_range(text, "--own"));
    wanted.ranges.back().is_own = true;
  }
  if (!given.objective.empty()) wanted.terms.clear();
  for (const std::string& text : given.objective) wanted.terms.push_back(analysis::parse_fit_term(text));
  for (std::size_t i = 0; i < wanted.terms.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (wanted.terms[i].figure == wanted.terms[k].figure)
        throw app::UsageError(
            "--objective: " + std::string(analysis::kFitFigureNames[static_cast<std::size_t>(wanted.terms[i].figure)]) +
            " is given twice");
    }
  }
  if (wanted.terms.empty()) wanted.terms.emplace_back();
  if (wanted.ranges.empty())
    throw app::UsageError(
        "--vary: nothing may vary; give at least one POINTER=LOW:HIGH, such as /rules/0/rate=0.01:1:log");
  for (const analysis::FitRange& r : wanted.ranges) {
    if (!r.is_own || given.histories.size() > 1) continue;
    throw app::UsageError((r.place.empty() ? "--own: " : r.place + ": ") + r.name +
                          " is to be each history's own, and there is one; use --vary, or give several");
  }
  return wanted;
}

/// Every history with its scene. @throws UsageError, InvalidInput
std::vector<app::FitSource> sources_of(const Given& given) {
  std::vector<app::FitSource> sources;
  std::vector<std::string> words;
  for (const fs::path& history : given.histories) words.push_back(app::input_word(history));
  const std::vector<std::string> names = app::capture_names(words);
  for (std::size_t c = 0; c < words.size(); ++c) {
    const fs::path history = app::history_place(given.histories[c]);
    const app::PathKind kind = app::kind_of(history);
    if (kind != app::PathKind::History && kind != app::PathKind::Transfer)
      throw InvalidInput(history.string() + ": is no history or transfer; only those age");
    for (const app::FitSource& s : sources) {
      if (fs::weakly_canonical(s.history) == fs::weakly_canonical(history))
        throw app::UsageError("HISTORY: " + history.string() + " is given twice");
    }
    sources.push_back({history, names[c], given.scene});
  }
  for (const std::string& text : given.scene_of) {
    const std::size_t equals = text.find('=');
    const auto found = std::find(names.begin(), names.end(), text.substr(0, equals));
    if (equals == std::string::npos || found == names.end())
      throw app::UsageError("--scene-of: found `" + text +
                            "`; expected HISTORY=SCENE, HISTORY the name of one of several" +
                            did_you_mean(text.substr(0, equals), names));
    sources[found - names.begin()].scene = text.substr(equals + 1);
  }
  return sources;
}

/// Command that repeats it: options that are not the default, and nothing that changes no byte.
std::string fit_command(const Given& given, const analysis::FitTask& task) {
  std::string text = "patinate fit " + app::input_word(given.scene);
  for (const fs::path& history : given.histories) text += " " + app::input_word(history);
  for (const auto& [option, words] : {std::pair{" --scene-of ", &given.scene_of}, std::pair{" --vary ", &given.vary},
                                      std::pair{" --own ", &given.own}}) {
    for (const std::string& word : *words) text += option + app::shell_word(word);
  }
  if (!given.parameters.empty()) text += " --parameters " + app::input_word(given.parameters);
  for (const std::string& word : given.objective) text += " --objective " + app::shell_word(word);
  text += app::changed_options(option_values(task.objective), option_values(analysis::ObjectiveOptions{})) +
          app::changed_options(option_values(task.options), option_values(analysis::FitOptions{}));
  if (task.seed != static_cast<std::uint64_t>(CommonOptions{}.seed)) text += " --seed " + std::to_string(task.seed);
  return text + app::kAnyOutput;
}

std::string fit_figure(const Json& v) {
  return v.is_null() ? std::string("undefined") : short_number_text(rounded(v.get<double>(), 4));
}

/// States what was found, a line each.
void tell_fit(CommandRun& run, const Json& report) {
  run.note("objective: " + fit_figure(report.at("objective").at("before")) + " before, " +
           fit_figure(report.at("objective").at("after")) + " after");
  for (const Json& c : report.value("captures", Json::array()))
    run.note(c.at("name").get<std::string>() + ": " + fit_figure(c.at("before")) + " before, " +
             fit_figure(c.at("after")) + " after");
  if (const Json& held_out = report.at("held_out"); !held_out.is_null())
    run.note("frames after " + fit_figure(held_out.at("until")) + " " + held_out.at("unit").get<std::string>() +
             " (held out): " + fit_figure(held_out.at("before")) + " before, " + fit_figure(held_out.at("after")) +
             " after; holding the last fitted frame: " + fit_figure(held_out.at("last_frame")));
  for (const Json& c :
       report.at("held_out").is_null() ? Json::array() : report.at("held_out").value("captures", Json::array()))
    run.note(c.at("name").get<std::string>() + ", held out: " + fit_figure(c.at("before")) + " before, " +
             fit_figure(c.at("after")) + " after; holding the last fitted frame: " + fit_figure(c.at("last_frame")));
  for (const Json& p : report.at("parameters"))
    run.note(p.at("name").get<std::string>() + ": " + fit_figure(p.at("initial")) + " -> " + fit_figure(p.at("best")) +
             (p.at("unit") == "" ? "" : " " + p.at("unit").get<std::string>()) + "; " +
             p.at("verdict").get<std::string>());
}

}  // namespace

int cmd_fit(CommandRun& run) {
  analysis::FitTask task;
  Given given;
  bool require_converged = false;
  run.line.positional("SCENE", "A scene file with the starting values", given.scene);
  run.line.positional_list("HISTORY", "History to fit: a history, or a transfer; several are fitted together",
                           given.histories);
  run.line.output("FOLDER", "Folder to make: scene.json, report.html, report.json, evaluations.csv, before, after",
                  given.output);
  run.line.repeated("vary", "POINTER=LOW:HIGH[:log]", "A number of the scene, by its JSON pointer, and its range",
                    given.vary);
  run.line.repeated("own", "POINTER=LOW:HIGH[:log]", "The same, where each of several histories has a value of its own",
                    given.own);
  run.line.repeated("scene-of", "HISTORY=SCENE", "Another scene for one of several histories", given.scene_of);
  run.line.option("parameters", "FILE", "Ranges and figures from a JSON file (docs/fit.md)", given.parameters);
  run.line.repeated("objective", "FIGURE[=WEIGHT]", "What to bring near 0; default: color_distribution",
                    given.objective);
  run.line.suggestions({analysis::kFitFigureNames.begin(), analysis::kFitFigureNames.end()});
  run.line.options(task.objective);
  run.line.options(task.options);
  run.line.flag("require-converged", "Exit with status 1 if the budget ended the search; the folder is made anyway",
                require_converged);
  run.line.list(
      "Figures",
      {{"color_distribution", "distance between the distributions of color, mean over times"},
       {"mean_color", "distance between the mean colors, root mean square over times"},
       {"covered", "share of places that have changed visibly, mean difference over times, %"},
       {"onset, saturation",
        "difference of the times at which places reach a tenth, or nine tenths, of their change, % of the span"},
       {"color_by_control", "distance between colors at equal control and time"},
       {"rate_by_control", "change over the span by control"},
       {"ciede2000", "place by place, where the history lies on the scene's atlas"},
       {"contrast", "how much lightness varies at each wavelength of the pattern, L*"},
       {"rusted", "share of places that rust covers, as grade measures it, mean difference over times, %"}});
  run.line.usual({"vary", "objective", "until", "evaluations", "seeds"});
  run.line.example(
      "fit plate.json copper --vary /rules/0/rate=0.01:1:log --vary /appearance/patina/strength=0.2:3 --clock span -o "
      "copper_fit");
  run.line.example(
      "fit plate.json copper --vary /emitters/0/carries/water=0.1:2:log --objective covered --objective mean_color=0.5 "
      "--evaluations 200 -o copper_fit");
  run.line.example(
      "fit plate.json open shaded --vary /rules/0/rate=0.01:1:log --own /emitters/0/carries/water=0.1:2:log -o "
      "both_fit");
  if (!run.parse()) return 0;

  const Wanted wanted = wanted_of(given);
  task.terms = wanted.terms;
  task.seed = static_cast<std::uint64_t>(run.line.common().seed);
  run.notes(app::add_captures(task, sources_of(given), wanted.ranges, given.output, run.control("scene")));
  task.command = fit_command(given, task);
  const auto num_appearance = static_cast<std::size_t>(std::count_if(
      task.parameters.begin(), task.parameters.end(), [](const analysis::FitParameter& p) { return p.is_appearance; }));
  const analysis::FitBudget budget =
      analysis::fit_budget(task.options, task.parameters.size() - num_appearance, num_appearance);
  if (budget.evaluations < budget.least) throw app::UsageError(analysis::budget_problem(budget));
  const std::optional<JobStatus> status = run.make_folder(analysis::plan_fit(std::move(task), given.output), "fit");
  if (!status) return 0;
  const Json report = load_json(given.output / analysis::kFitReportFile);
  tell_fit(run, report);
  const bool is_converged = report.at("evaluations").at("converged").get<bool>();
  const std::string not_converged = "not converged: " + std::to_string(budget.evaluations) +
                                    " evaluations ended the search; a larger --evaluations resumes from here";
  if (!is_converged && !require_converged) run.note(not_converged);
  run.report_output(*status, given.output,
                    Json{{"objective", report.at("objective")},
                         {"held_out", report.at("held_out")},
                         {"parameters", report.at("parameters")},
                         {"evaluations", report.at("evaluations")}});
  if (!is_converged && require_converged) throw CannotComplete(given.output.string() + ": " + not_converged);
  return 0;
}

}  // namespace patinate::cli
