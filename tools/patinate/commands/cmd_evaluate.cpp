#include <nlohmann/json.hpp>

#include "app/evaluation/evaluated_maps.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "transfer/exemplar/appearance_cache.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// A folder or manifest is a transfer, or a mistake; other files are coordinate maps.
bool is_transfer(const fs::path& path) {
  if (!fs::is_directory(path) && lower_extension(path) != ".json") return false;
  app::require_transfer(path);
  return true;
}

/// Command that repeats it: options that are not the default, and nothing that changes no byte.
std::string evaluate_command(const analysis::EvaluationTask& task, const std::vector<fs::path>& maps,
                             const app::ForeignMapOptions& foreign) {
  std::string text = "patinate evaluate";
  for (const fs::path& map : maps) text += " " + app::input_word(map);
  if (!foreign.history.empty()) text += " --history " + app::input_word(foreign.history);
  if (!foreign.control.empty()) text += " --control " + app::shell_word(app::named_control(foreign.control));
  if (!foreign.picture.empty()) text += " --picture " + app::input_word(foreign.picture);
  text += app::changed_options(option_values(task.options), option_values(analysis::EvaluationOptions{}));
  if (task.seed != static_cast<std::uint64_t>(CommonOptions{}.seed)) text += " --seed " + std::to_string(task.seed);
  return text + app::kAnyOutput;
}

}  // namespace

int cmd_evaluate(CommandRun& run) {
  analysis::EvaluationTask task;
  std::vector<fs::path> maps;
  app::ForeignMapOptions foreign;
  fs::path output;
  transfer::CacheOptions cache;
  run.line.positional_list("MAP", "Transfers, or coordinate maps of other tools (EXR, TIFF, 16-bit PNG, .nnf)", maps);
  run.line.output("REPORT", "Folder to make: evaluation.html, evaluation.json", output);
  run.line.option("history", "HISTORY", "For maps of other tools: the history that was copied from", foreign.history);
  run.line.option(
      "control", "SPEC",
      "For maps of other tools: [SOURCE=]MAP, what the tool followed, in the values of the history's control (0 to 1)",
      foreign.control);
  run.line.option("picture", "IMAGE",
                  "For one map of another tool: the picture that it made, at the history's last frame",
                  foreign.picture);
  run.line.options(task.options);
  run.line.options(cache);
  run.line.example("evaluate copper_hydrant copper_bust -o evaluation");
  run.line.example("evaluate ours theirs.exr --history rust --control height=target.png -o evaluation");
  if (!run.parse()) return 0;
  task.seed = static_cast<std::uint64_t>(run.line.common().seed);
  task.command = evaluate_command(task, maps, foreign);
  for (const fs::path& map : maps) {
    task.maps.push_back(is_transfer(map) ? app::transfer_item(map, task.options, task.seed, cache)
                                         : app::foreign_item(map, foreign, task.options, task.seed, cache));
  }
  const std::optional<JobStatus> status =
      run.make_folder(analysis::plan_evaluation(std::move(task), output), "evaluate");
  if (!status) return 0;

  const Json report = load_json(output / analysis::kEvaluationFile);
  for (const Json& map : report.at("maps")) {
    run.note(map.at("name").get<std::string>() + ":");
    for (const Json& f : map.at("figures")) {
      if (f.at("value").is_null()) continue;
      std::string line = "  " + f.at("title").get<std::string>() + ": " +
                         short_number_text(rounded(f.at("value").get<double>(), 3)) + " " +
                         f.at("unit").get<std::string>();
      if (f.contains("split"))
        line += " (source against itself: " + short_number_text(rounded(f.at("split").get<double>(), 3)) + ")";
      run.note(line);
    }
  }
  run.report_output(*status, output, Json{{"maps", report.at("maps")}});
  return 0;
}

}  // namespace patinate::cli
