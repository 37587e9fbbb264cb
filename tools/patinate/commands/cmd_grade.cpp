#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

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

std::string grade_command(const analysis::GradeTask& task, const std::vector<std::string>& regions,
                          const std::string& scribe) {
  std::string text = "patinate grade " + app::input_word(task.history);
  for (const std::string& region : regions) text += " --region " + app::shell_word(region);
  if (!scribe.empty()) text += " --scribe " + scribe;
  if (!task.labels.empty()) text += " --labels " + app::input_word(task.labels);
  if (!task.rules.empty()) text += " --rules " + app::input_word(task.rules);
  if (!task.limits.empty()) text += " --limits " + app::input_word(task.limits);
  return text + app::changed_options(option_values(task.options), option_values(analysis::GradeOptions{})) +
         app::kAnyOutput;
}

/// "auto" or "30,11,30,29,0.5".
analysis::ScribeRequest scribe_from(const std::string& text) {
  if (text.empty()) return {};
  if (text == "auto") return {.is_wanted = true};
  std::vector<double> v;
  for (const std::string& part : split(text, ',')) v.push_back(parse_number(part).value_or(std::nan("")));
  const bool is_scratch = v.size() == 5 && v[4] >= 0.0 && (v[0] != v[2] || v[1] != v[3]) &&
                          std::all_of(v.begin(), v.end(), [](double n) { return std::isfinite(n); });
  if (!is_scratch)
    throw app::UsageError("--scribe: found `" + text +
                          "`; expected auto, or X0,Y0,X1,Y1,WIDTH in mm with two different ends");
  return {.is_wanted = true, .given = analysis::Scribe{v[0], v[1], v[2], v[3], v[4]}};
}

}  // namespace

int cmd_grade(CommandRun& run) {
  analysis::GradeTask task;
  fs::path output;
  std::vector<std::string> regions;
  std::string scribe;
  run.line.positional("HISTORY", "A history, or a transfer", task.history);
  run.line.output("REPORT", "Folder to make: report.html, report.json, grades.csv", output);
  run.line.repeated("region", "NAME=X,Y,...",
                    "A polygon in mm from the upper left corner, or NAME=MASK.png; without any: the whole sample",
                    regions);
  run.line.option("scribe", "X0,Y0,X1,Y1,WIDTH",
                  "The scratch from which creep is measured, in mm; auto: it is found in the unexposed photograph",
                  scribe);
  run.line.option("labels", "FILE",
                  "Image of the last photograph's size on which rust is marked: not 0; its color then counts as rust",
                  task.labels);
  run.line.option("limits", "FILE", "Limits to keep to, one a line, such as `Ri <= 2 at 480 h`", task.limits);
  run.line.option("rules", "FILE",
                  "File with the standards' scales and the definition of rust; it replaces the built-in one",
                  task.rules);
  run.line.options(task.options);
  run.line.example("grade panel -o report");
  run.line.example("grade panel --region upper=5,5,70,5,70,50,5,50 --limits limits.txt -o report");
  run.line.checked([&] {
    task.scribe = scribe_from(scribe);
    for (const std::string& region : regions) add_region(region, task);
  });
  if (!run.parse()) return 0;
  task.command = grade_command(task, regions, scribe);
  task.history = app::history_place(task.history);
  const app::PathKind kind = app::kind_of(task.history);
  if (kind != app::PathKind::History && kind != app::PathKind::Transfer)
    throw InvalidInput(task.history.string() + ": is no history or transfer; only those age");
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
