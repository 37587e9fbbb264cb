#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/fit/field_job.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/repeating_command.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/field_scene.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

std::string field_figure(const Json& v) {
  return v.is_null() ? std::string("undefined") : short_number_text(rounded(v.get<double>(), 4));
}

/// "12.1 to 7.4 Delta E by place (62 % of its square)".
std::string change_text(const Json& report, const char* frames, const char* explained) {
  const Json& share = report.at(explained);
  return field_figure(report.at("single").at(frames).at("by_place")) + " to " +
         field_figure(report.at("after").at(frames).at("by_place")) + " Delta E by place" +
         (share.is_null() ? ""
                          : " (" + short_number_text(rounded(100.0 * share.get<double>(), 3)) + " % of its square)");
}

/// What was found, a line each.
void tell_field(CommandRun& run, const Json& report) {
  run.note("from the best numbers for all places to fields, frames seen: " +
           change_text(report, "seen", "explained_seen"));
  if (!report.at("after").at("held_out").is_null())
    run.note("frames that were not seen: " + change_text(report, "held_out", "explained_held_out") + "; their colors " +
             field_figure(report.at("single").at("held_out").at("color_distribution")) + " to " +
             field_figure(report.at("after").at("held_out").at("color_distribution")) +
             "; the last frame seen, held: " + field_figure(report.at("last_frame")));
  for (const Json& f : report.at("fields"))
    run.note(f.at("name").get<std::string>() + ": " + field_figure(f.at("low")) + " to " + field_figure(f.at("high")) +
             (f.at("unit") == "" ? "" : " " + f.at("unit").get<std::string>()) + "; " +
             std::to_string(f.at("coefficients").size()) + " numbers, of which the data decide " +
             short_number_text(rounded(f.at("effective_numbers").get<double>(), 3)));
}

}  // namespace

int cmd_field(CommandRun& run) {
  analysis::FieldTask task;
  fs::path scene_file, output;
  std::vector<std::string> vary;
  run.line.positional("SCENE", "A scene file with one object", scene_file);
  run.line.positional("HISTORY", "What it should come close to, place by place: a history, or a transfer",
                      task.history);
  run.line.output("FOLDER", "Folder to make: scene.json, fields, report.html, report.json, after", output);
  run.line.repeated("vary", "POINTER=LOW:HIGH[:log]",
                    "The rate of a rule or an initial amount, and between which values it may differ", vary);
  run.line.options(task.options);
  run.line.example(
      "fit field plate.json copper --vary /rules/0/rate=0.01:1:log --places equal --until 300 -o copper_field");
  if (!run.parse()) return 0;
  if (vary.empty())
    throw UsageError("--vary: nothing may vary; give at least one POINTER=LOW:HIGH, such as /rules/0/rate=0.01:1:log");
  std::vector<analysis::FitRange> ranges;
  for (const std::string& text : vary) ranges.push_back(analysis::parse_fit_range(text));
  const std::string word = input_word(task.history);
  task.history = history_place(task.history);
  const PathKind kind = kind_of(task.history);
  if (kind != PathKind::History && kind != PathKind::Transfer)
    throw InvalidInput(task.history.string() + ": is no history or transfer; only those age");
  const FieldScene scene(scene_file, ranges, run.control("scene"));
  run.notes(scene.scene().notes());
  task.parameters = scene.scene().parameters();
  task.outline = scene.scene().outline();
  task.model_name = task.outline.name;
  task.coverage = scene.coverage();
  task.age = scene.age();
  task.write_model = [scene, output](const fs::path& folder, const std::vector<ImageF>& values) {
    scene.write(folder, output, values);
  };
  task.add_inputs = [scene](JobInputs& inputs) { scene.scene().add_inputs(inputs); };
  task.command = "patinate fit field " + input_word(scene_file) + " " + word;
  for (const std::string& text : vary) task.command += " --vary " + shell_word(text);
  task.command += changed_options(option_values(task.options), option_values(analysis::FieldOptions{})) + kAnyOutput;
  const std::optional<JobStatus> status = run.make_folder(analysis::plan_field(std::move(task), output), "field");
  if (!status) return 0;
  const Json report = load_json(output / analysis::kFieldReportFile);
  tell_field(run, report);
  run.report_output(*status, output,
                    Json{{"fields", report.at("fields")},
                         {"single", report.at("single")},
                         {"after", report.at("after")},
                         {"explained_seen", report.at("explained_seen")},
                         {"explained_held_out", report.at("explained_held_out")}});
  return 0;
}

}  // namespace patinate::cli
