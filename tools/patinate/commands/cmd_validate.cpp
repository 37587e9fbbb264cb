#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/job/job_record.h"
#include "libcommon/job/partial_folder.h"
#include "patinate/core/error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/info/path_actions.h"

namespace patinate::cli {

namespace {

/// Compares the files of a finished folder with what they were when it was made.
void check_record(const std::filesystem::path& path, Checks& checks) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::is_directory(path, error) ? path : folder_of(path);
  const JobRecord record = read_job_record(folder, manifest_key(folder, kJobRecordFile));
  const FolderDamage damage = damage_of(folder, record, Looked::AtContent);
  const auto tell = [&](const std::string& file, const char* what) {
    checks.run(
        [&] { throw IoError((folder / file).string(), std::string(what) + "; make the result again with --force"); });
  };
  for (const std::string& file : damage.lost) tell(file, "is lost");
  for (const std::string& file : damage.altered) tell(file, "is no longer what was made");
}

}  // namespace

int cmd_validate(CommandRun& run) {
  std::filesystem::path path;
  run.line.positional("PATH", path_kinds_text(), path);
  run.line.without({"seed", "force", "dry_run"});
  run.line.example("validate copper");
  if (!run.parse()) return 0;
  Checks checks;
  const RunControl control = run.control("checking");
  checks.run([&] { check_path(path, checks, control); });
  if (checks.problems().empty()) check_record(path, checks);
  control.report(1.0);

  if (checks.problems().empty()) {
    run.report(Json{{"valid", true}, {"problems", Json::array()}}, path.string() + ": OK");
    return 0;
  }
  // Problems are printed as errors are: one line each on stderr.
  run.note_problems(checks.problems());
  if (run.line.common().json) run.report(Json{{"valid", false}, {"problems", checks.problems()}}, "");
  return 3;
}

}  // namespace patinate::cli
