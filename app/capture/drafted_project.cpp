#include "app/capture/drafted_project.h"

#include <nlohmann/json.hpp>
#include <string>

#include "app/request/output_file.h"
#include "capture/project/capture_project.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"

namespace patinate::app {

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

OutputWork drafted_project_work(const capture::ProjectDraft& draft, const std::filesystem::path& project) {
  const std::string text = draft.text, hints = hints_text(draft);
  const OutputFile file = text_file(project, text);
  OutputWork work{.output = project,
                  .label = "init",
                  .key = kSameText,
                  .existing_key = file.existing_key,
                  .beside = {text_file(hints_file(project), hints)},
                  .report = std::make_shared<const Json>(Json{{"found", draft.found}, {"check", draft.to_check}})};
  work.make = [=](const RunControl&) {
    write_atomically(project, text);
    write_atomically(hints_file(project), hints);
  };
  return work;
}

std::string draft_refusal(const std::filesystem::path& project) {
  try {
    (void)capture::read_capture_project(project);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

}  // namespace patinate::app
