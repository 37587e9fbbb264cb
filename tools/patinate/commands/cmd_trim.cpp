#include <filesystem>
#include <nlohmann/json.hpp>

#include "libcommon/job/job_inputs.h"
#include "patinate/history/trim_history.h"
#include "patinate/transfer/transfer_io.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

JobPlan plan_trim(const fs::path& history, const TrimOptions& options, const fs::path& output) {
  const HistoryReader reader(history);
  TrimmedHistory trimmed = trim_history(reader.manifest(), options);
  JobInputs inputs("trim", 1);
  inputs.add_content("history", "the history", transfer::history_content_key(reader));
  inputs.add_options(option_values(options));
  JobPlan plan = inputs.plan(output, kHistoryManifestFile);
  trimmed.manifest.key = plan.key;
  std::vector<fs::path> outputs;
  for (const TrimmedHistory::File& file : trimmed.files) outputs.push_back(file.to);
  plan.items.push_back(
      {.name = "files",
       .outputs = outputs,
       .run = [from = reader.folder(), files = trimmed.files](const fs::path& folder, const RunControl& control) {
         copy_history_files(from, files, folder, control);
       }});
  plan.join = [manifest = trimmed.manifest](const fs::path& folder, const RunControl&) {
    write_history_manifest(folder / kHistoryManifestFile, manifest);
  };
  return plan;
}

}  // namespace

int cmd_trim(CommandRun& run) {
  fs::path history, output;
  TrimOptions options;
  run.line.positional("HISTORY", "A history or a simulation", history);
  run.line.output("SHORTER", "Folder to make: the history of the frames that stay", output);
  run.line.options(options);
  run.line.without({"seed"});
  run.line.example("trim copper --until 300 -o copper_seen");
  run.line.example("trim copper --from 60 --every 4 -o copper_coarse");
  if (!run.parse()) return 0;
  history = history_place(history);
  if (kind_of(history) != PathKind::History)
    throw InvalidInput(history.string() + ": is no history; only those have frames to trim");
  const JobPlan plan = plan_trim(history, options, output);
  const std::optional<JobStatus> status = run.make_folder(plan, "trim");
  if (!status) return 0;
  const HistoryManifest made = read_history_manifest(output);
  run.report_output(*status, output,
                    Json{{"frames", made.frames.size()},
                         {"first_time", made.frames.front().time},
                         {"last_time", made.frames.back().time},
                         {"time_unit", time_unit_text(made.time_unit)}});
  return 0;
}

}  // namespace patinate::cli
