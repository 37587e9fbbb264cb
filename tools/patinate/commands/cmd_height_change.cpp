#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "capture/relief/relief_job.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

std::string step_line(const Json& step) {
  const auto um = [&](const char* name) { return short_number_text(rounded(step.at(name).get<double>(), 3)); };
  return step.at("scan").get<std::string>() + ": " + um("mean_change_um") + " +- " + um("mean_change_stddev_um") +
         " um on the mean, " + fixed_percent_text(step.at("changed_share").get<double>()) + " changed, " +
         short_number_text(rounded(step.at("gained").at("mm3").get<double>(), 3)) + " mm3 gained, " +
         short_number_text(rounded(-step.at("lost").at("mm3").get<double>(), 3)) + " lost";
}

}  // namespace

int cmd_height_change(CommandRun& run) {
  fs::path registered, output, stable;
  std::string unit, time_unit = "d";
  std::vector<double> times;
  capture::ReliefOptions options;
  run.line.positional("REGISTERED", "A folder of `register`, or its registration.json: scans in the order of time",
                      registered);
  run.line.output("FOLDER", "Folder to make: a history with heights, change/, relief.json, relief.csv, report.html",
                  output);
  run.line.option("stable", "IMAGE",
                  "Image that is white where the surface is stable, painted over a change/NNNN.png of a run without it",
                  stable);
  run.line.numbers("times", "T", "When the scans were made; default their numbers from 0", times);
  run.line.option("time_unit", "UNIT", "Unit of --times", time_unit);
  run.line.choices({"s", "min", "h", "d", "yr", "a"});
  run.line.option("unit", "UNIT", "Length unit of the scans, where the registration does not say it", unit);
  run.line.choices({"um", "mm", "cm", "m"});
  run.line.options(options);
  run.line.without({"seed"});
  run.line.example("height-change registered --times 0,30,365 -o receding");
  run.line.example("height-change registered --stable stays.png --window-mm 2 -o receding");
  if (!run.parse()) return 0;

  std::optional<double> mm_per_unit;
  if (!unit.empty()) mm_per_unit = find_mm_per_unit(unit);
  capture::ReliefTask task = capture::relief_task_of(registered, mm_per_unit);
  task.name = output.filename().string();
  task.stable = stable;
  task.time_unit = parse_time_unit(time_unit);
  task.options = options;
  try {
    capture::set_times(times, task);
  } catch (const InvalidInput& e) {
    throw app::UsageError(std::string("--") + e.what());
  }
  const std::optional<JobStatus> status =
      run.make_folder(capture::plan_relief(std::move(task), output), "height-change");
  if (!status) return 0;
  const Json relief = load_json(output / capture::kReliefFile);
  for (const Json& warning : relief.at("warnings"))
    run.note(warning.at("text").get<std::string>() +
             (warning.contains("cure") ? ": " + warning.at("cure").get<std::string>() : ""));
  for (const Json& step : relief.at("steps")) {
    if (!step.at("reference").get<bool>()) run.note(step_line(step));
  }
  run.report_output(*status, output,
                    Json{{"window_mm", relief.at("window_mm")},
                         {"texel_mm", relief.at("texel_mm")},
                         {"steps", relief.at("steps")},
                         {"warnings", relief.at("warnings")}});
  return 0;
}

}  // namespace patinate::cli
