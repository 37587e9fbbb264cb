#include <nlohmann/json.hpp>

#include "capture/ingest/ingest.h"
#include "libcommon/history/history.h"
#include "tools/patinate/commands.h"
#include "tools/patinate/path_kind.h"

namespace patinate {

int cmd_ingest(CommandRun& run) {
  std::filesystem::path project_file, output;
  IngestOptions options;
  run.line.positional("CAPTURE", "capture.json, or the folder that holds it (docs/capture.md)", project_file);
  run.line.output("HISTORY", "Folder of the material history to make", output);
  run.line.options(options);
  run.line.example("ingest photos/capture.json -o copper");
  if (!run.parse()) return 0;

  const CaptureProject project = read_capture_project(capture_file(project_file));
  const JobPlan plan = plan_ingest(project, options, output);
  const JobStatus status = run_job(plan, run.job_options(), run.control("ingest"));
  if (status == JobStatus::Done) write_run_record(output, run.command_line(), run.seconds());

  const HistoryManifest history = read_history_manifest(output);
  Json controls = Json::array();
  for (const ControlParameter& c : history.controls) controls.push_back(c.name);
  run.report_output(status, output, Json{{"frames", history.frames.size()}, {"controls", controls}});
  return 0;
}

}  // namespace patinate
