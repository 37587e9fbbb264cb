#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/grading/grade_groups.h"
#include "analysis/grading/grade_job.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "app/request/usage_error.h"
#include "libcommon/core/text.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// "edge=mask.png" or "left=0,0,40,0,40,60".
void add_region(const std::string& text, analysis::GradeTask& task) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw app::UsageError("--region: found `" + text + "`; expected NAME=X,Y,X,Y,X,Y in mm, or NAME=MASK.png");
  const std::string name = text.substr(0, at), value = text.substr(at + 1);
  std::vector<double> corners;
  for (const std::string& part : split(value, ',')) {
    const std::optional<double> number = parse_number(part);
    if (!number) {
      task.masks.emplace_back(name, value);
      return;
    }
    corners.push_back(*number);
  }
  task.polygons.emplace_back(name, std::move(corners));
}

std::string words_of(const std::vector<fs::path>& paths) {
  std::string text;
  for (const fs::path& path : paths) text += " " + app::input_word(path);
  return text;
}

/// @param panels  Those of A, as they were given. @param against  Those of B.
std::string grade_command(const analysis::GradeTask& task, const std::vector<fs::path>& panels,
                          const std::vector<fs::path>& against, const std::vector<std::string>& regions,
                          const std::vector<std::string>& scribes) {
  std::string text = "patinate grade" + words_of(panels);
  if (!against.empty()) text += " --against" + words_of(against);
  for (const std::string& region : regions) text += " --region " + app::shell_word(region);
  for (const std::string& scribe : scribes) text += " --scribe " + scribe;
  if (!task.labels.empty()) text += " --labels " + app::input_word(task.labels);
  if (!task.rules.empty()) text += " --rules " + app::input_word(task.rules);
  if (!task.limits.empty()) text += " --limits " + app::input_word(task.limits);
  return text + app::changed_options(option_values(task.options), option_values(analysis::GradeOptions{})) +
         app::kAnyOutput;
}

/// "30,11,30,29,0.5".
analysis::Scribe scribe_from(const std::string& text) {
  std::vector<double> v;
  for (const std::string& part : split(text, ',')) v.push_back(parse_number(part).value_or(std::nan("")));
  const bool is_scratch = v.size() == 5 && v[4] >= 0.0 && (v[0] != v[2] || v[1] != v[3]) &&
                          std::all_of(v.begin(), v.end(), [](double n) { return std::isfinite(n); });
  if (!is_scratch)
    throw app::UsageError("--scribe: found `" + text +
                          "`; expected auto, or X0,Y0,X1,Y1,WIDTH in mm with two different ends");
  return {v[0], v[1], v[2], v[3], v[4]};
}

/// "auto" alone, or one scribe a text.
analysis::ScribeRequest scribes_from(const std::vector<std::string>& texts) {
  analysis::ScribeRequest request{.is_wanted = !texts.empty()};
  if (texts == std::vector<std::string>{"auto"}) return request;
  for (const std::string& text : texts) {
    if (text == "auto") throw app::UsageError("--scribe: auto finds all scratches; give it alone");
    request.given.push_back(scribe_from(text));
  }
  return request;
}

void require_history(const fs::path& path) {
  const app::PathKind kind = app::kind_of(path);
  if (kind != app::PathKind::History && kind != app::PathKind::Transfer)
    throw InvalidInput(path.string() + ": is no history or transfer; only those age");
}

/// Replicates, and those of another treatment. @param command_of  Command that grades one panel alone.
template <class CommandOf>
int grade_groups(CommandRun& run, const analysis::GradeTask& task, const std::vector<fs::path>& panels,
                 const std::vector<fs::path>& against, const CommandOf& command_of, const fs::path& output) {
  analysis::GradeGroupsTask groups{
      .a = {}, .names = {}, .seed = static_cast<std::uint64_t>(run.line.common().seed), .command = task.command};
  if (run.line.common().seed != CommonOptions{}.seed)
    groups.command += " --seed " + std::to_string(run.line.common().seed);
  for (const auto& [side, paths] : {std::pair(&groups.a, &panels), std::pair(&groups.b, &against)}) {
    for (const fs::path& path : *paths) {
      groups.names.push_back(app::input_word(path));
      analysis::GradeTask& panel = side->emplace_back(task);
      panel.history = app::history_place(path);
      require_history(panel.history);
      panel.command = command_of(path);
    }
  }
  const std::optional<JobStatus> status =
      run.make_folder(analysis::plan_grade_groups(std::move(groups), output), "grade");
  if (!status) return 0;
  const Json report = load_json(output / analysis::kGradeReportFile);
  const auto listed = [](const Json& names) {
    std::string text;
    for (const Json& name : names) text += (text.empty() ? "" : ", ") + name.get<std::string>();
    return text;
  };
  for (const Json& grade : report.at("grades")) {
    const std::string b = listed(grade.at("b"));
    run.note(grade.at("region").get<std::string>() + ": " + grade.at("title").get<std::string>() + ": " +
             listed(grade.at("a")) + (b.empty() ? "" : " against " + b));
  }
  for (const Json& sentence : report.at("verdict")) run.note(sentence.get<std::string>());
  bool has_failed = false;
  for (const char* side : {"a", "b"}) {
    for (const Json& panel : report.at(side)) {
      if (panel.at("keeps_limits").get<bool>()) continue;
      has_failed = true;
      run.note(panel.at("name").get<std::string>() + ": a limit is not kept; see " +
               panel.at("report").get<std::string>());
    }
  }
  run.report_output(
      *status, output,
      Json{{"figures", report.at("figures")}, {"grades", report.at("grades")}, {"verdict", report.at("verdict")}});
  return has_failed ? 1 : 0;
}

}  // namespace

int cmd_grade(CommandRun& run) {
  analysis::GradeTask task;
  fs::path output;
  std::vector<std::string> regions, scribes;
  std::vector<fs::path> panels, against;
  run.line.positional("HISTORY", "A history, or a transfer", task.history);
  run.line.positional_list("REPLICATE", "More panels that were coated and exposed alike", panels);
  run.line.required(false);
  run.line.output("REPORT", "Folder to make: report.html, report.json, grades.csv", output);
  run.line.repeated("region", "NAME=X,Y,...",
                    "A polygon in mm from the upper left corner, or NAME=MASK.png; without any: the whole sample",
                    regions);
  run.line.repeated("scribe", "X0,Y0,X1,Y1,WIDTH",
                    "A scratch from which creep is measured, in mm; auto: all are found in the unexposed photograph",
                    scribes);
  run.line.paths("against", "HISTORY...", "Panels of another treatment, two or more, against two or more of the first",
                 against);
  run.line.option("labels", "FILE",
                  "Image of the last photograph's size on which rust is marked: not 0; its color then counts as rust",
                  task.labels);
  run.line.option("limits", "FILE", "Limits to keep to, one a line, such as `Ri <= 2 at 480 h`", task.limits);
  run.line.option("rules", "FILE",
                  "File with the standards' scales and the definition of rust; it replaces the built-in one",
                  task.rules);
  run.line.options(task.options);
  run.line.example("grade panel -o report");
  run.line.example("grade panel_1 panel_2 panel_3 --against bare_1 bare_2 bare_3 --scribe auto -o report");
  run.line.example("grade panel --region upper=5,5,70,5,70,50,5,50 --limits limits.txt -o report");
  run.line.checked([&] {
    task.scribe = scribes_from(scribes);
    for (const std::string& region : regions) add_region(region, task);
  });
  if (!run.parse()) return 0;
  panels.insert(panels.begin(), task.history);
  task.command = grade_command(task, panels, against, regions, scribes);
  if (panels.size() > 1 || !against.empty()) {
    const auto alone = [&](const fs::path& path) { return grade_command(task, {path}, {}, regions, scribes); };
    return grade_groups(run, task, panels, against, alone, output);
  }
  task.history = app::history_place(task.history);
  require_history(task.history);
  const std::optional<JobStatus> status = run.make_folder(analysis::plan_grade(task, output), "grade");
  if (!status) return 0;

  const Json report = load_json(output / analysis::kGradeReportFile);
  for (const Json& note : report.at("notes")) run.note(note.get<std::string>());
  for (const Json& line : report.at("summary")) run.note(line.get<std::string>());
  bool has_failed = false;
  for (const Json& limit : report.at("limits")) {
    const auto state = limit.at("state").get<std::string>();
    has_failed = has_failed || state == "fail" || state == "not tested";
    run.note(limit.at("region").get<std::string>() + ": " + limit.at("limit").get<std::string>() + ": " + state + ", " +
             limit.at("found").get<std::string>());
  }
  run.report_output(
      *status, output,
      Json{{"summary", report.at("summary")}, {"limits", report.at("limits")}, {"notes", report.at("notes")}});
  return has_failed ? 1 : 0;
}

}  // namespace patinate::cli
