#include <nlohmann/json.hpp>

#include "app/capture/drafted_project.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

int cmd_init(CommandRun& run) {
  std::filesystem::path folder, output;
  std::string only;
  run.line.positional("FOLDER", "Folder of photographs, or with a movie", folder);
  run.line.output("PROJECT", "Project file to write; FOLDER/capture.json when not given", output);
  run.line.required(false);
  run.line.option("only", "PATTERN", "Names of the photographs, as 'IMG_*.jpg', where others lie beside them", only);
  run.line.example("init photos");
  run.line.example("init photos --only 'IMG_*.jpg'");
  if (!run.parse()) return 0;
  if (output.empty()) output = folder / "capture.json";

  const capture::ProjectDraft draft = capture::draft_capture_project(folder, output.parent_path(), only);
  const app::OutputWork work = app::drafted_project_work(draft, output);
  const std::optional<JobStatus> status = run.check_files(app::files_of(work), work.key);
  if (!status) return 0;
  if (*status == JobStatus::Done) work.make({});
  for (const std::string& line : draft.found) run.note("found: " + line);
  for (const std::string& line : draft.to_check) run.note("check: " + line);
  if (const std::string refusal = app::draft_refusal(output); !refusal.empty())
    run.note("check: `ingest` will refuse the draft as it is: " + refusal);
  run.report_output(*status, output, *work.report);
  return 0;
}

}  // namespace patinate::cli
