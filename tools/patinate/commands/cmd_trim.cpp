#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/history/trimmed_history.h"
#include "app/request/path_kind.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

int cmd_trim(CommandRun& run) {
  fs::path history, output;
  TrimOptions options;
  run.line.positional("HISTORY", "A history or a simulation", history);
  run.line.output("SHORTER", "Folder to make: the history of the frames that stay", output);
  run.line.options(options);
  run.line.without({"seed"});
  run.line.example("history trim copper --until 300 -o copper_seen");
  run.line.example("history trim copper --from 60 --every 4 -o copper_coarse");
  if (!run.parse()) return 0;
  history = app::history_place(history);
  if (app::kind_of(history) != app::PathKind::History)
    throw InvalidInput(history.string() + ": is no history; only those have frames to trim");
  const JobPlan plan = app::plan_trim(history, options, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "trim");
  if (!status) return 0;
  run.report_output(*status, output, frames_json(output));
  return 0;
}

}  // namespace patinate::cli
