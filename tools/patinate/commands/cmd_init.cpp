#include <nlohmann/json.hpp>

#include "app/request/output_file.h"
#include "capture/project/capture_project.h"
#include "capture/project/draft_project.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

/// capture.json -> capture.hints.txt: JSON has no comments.
std::filesystem::path hints_file(std::filesystem::path project) { return project.replace_extension(".hints.txt"); }

std::string hints_text(const capture::ProjectDraft& draft) {
  std::string text;
  for (const std::string& line : draft.found) text += "found: " + line + "\n";
  for (const std::string& line : draft.to_check) text += "check: " + line + "\n";
  for (const std::string& line : draft.hints) text += line + "\n";
  return text + "All members: docs/capture.md and docs/schema/capture.schema.json.\n";
}

}  // namespace

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
  const std::optional<JobStatus> status = run.check_files(
      {app::text_file(output, draft.text), app::text_file(hints_file(output), hints_text(draft))}, app::kSameText);
  if (!status) return 0;
  if (*status == JobStatus::Done) {
    write_atomically(output, draft.text);
    write_atomically(hints_file(output), hints_text(draft));
  }
  for (const std::string& line : draft.found) run.note("found: " + line);
  for (const std::string& line : draft.to_check) run.note("check: " + line);
  try {
    (void)capture::read_capture_project(output);
  } catch (const InputError& e) {
    run.note(std::string("check: `ingest` will refuse the draft as it is: ") + e.what());
  }
  run.report_output(*status, output, Json{{"found", draft.found}, {"check", draft.to_check}});
  return 0;
}

}  // namespace patinate::cli
