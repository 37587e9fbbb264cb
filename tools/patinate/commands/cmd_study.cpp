#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/interruption.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/study/snakefile.h"
#include "tools/patinate/study/study_folder.h"
#include "tools/patinate/study/study_json.h"
#include "tools/patinate/study/study_plans.h"
#include "tools/patinate/study/study_report.h"
#include "tools/patinate/study/study_run.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr int kCannot = 1, kInput = 3;
constexpr std::chrono::seconds kEndOfSteps{10};  ///< That processes of steps may take to end.
const std::vector<std::string> kKinds{"run", "export", "report"};

struct JobsOptions {
  int jobs = 0;
};
void describe(OptionVisitor& v, JobsOptions& o) {
  v.visit({"jobs", "Cells at a time; 0 = one a processor", "", between(0, 4096)}, o.jobs);
}

/// Places the study, unless something is wrong with it: then says all of it.
std::optional<StudyFolder> placed(CommandRun& run, const fs::path& file, const fs::path& folder) {
  std::vector<std::string> problems;
  const Study study = read_study(file, folder, problems);
  if (!problems.empty()) {
    run.note_problems(problems);
    return std::nullopt;
  }
  return place_study(study, folder);
}

/// What is left, as far as the folder tells.
int report_steps_left(CommandRun& run, const fs::path& file, const fs::path& folder) {
  std::vector<std::string> problems;
  const Study study = read_study(file, folder, problems);
  if (!problems.empty()) {
    run.note_problems(problems);
    return kInput;
  }
  std::size_t num_steps = 0;
  Json left = Json::array();
  std::string text;
  for (const StudyPart& part : study.parts) {
    for (const StudyCell& cell : part.cells) {
      for (const StudyStep& step : part.steps) {
        ++num_steps;
        std::error_code error;
        if (fs::exists(folder / done_file(step, {.name = cell.name, .factors = {}, .commands = {}}), error)) continue;
        left.push_back({{"cell", cell.name}, {"step", step.name}});
        if (left.size() <= 20) text += "\n  " + cell.name + ": " + step.name;
      }
    }
  }
  if (left.size() > 20) text += "\n  and " + std::to_string(left.size() - 20) + " more";
  run.report(Json{{"steps", num_steps}, {"left", left}}, folder.string() + ": " + std::to_string(left.size()) + " of " +
                                                             std::to_string(num_steps) + " steps are left" + text);
  return 0;
}

int end_with(CommandRun& run, const StudyFolder& study, const StudyReport& report) {
  const fs::path page = study.path / "report.html";
  run.note(page.string() + ": " + std::to_string(report.num_done) + " cells done, " +
           std::to_string(report.num_failed) + " failed, " + std::to_string(report.num_open) + " not run");
  if (run.line.common().json) {
    run.report(Json{{"output", study.path.string()},
                    {"report", page.string()},
                    {"done", report.num_done},
                    {"failed", report.num_failed},
                    {"not_run", report.num_open}},
               "");
  }
  return 0;
}

int run_here(CommandRun& run, const fs::path& file, const fs::path& folder, int jobs) {
  if (run.line.common().dry_run) return report_steps_left(run, file, folder);
  const std::optional<StudyFolder> study = placed(run, file, folder);
  if (!study) return kInput;
  take_time_to_end(kEndOfSteps);
  const RunControl control = run.control("study");
  const StudyOutcome outcome = run_study(*study, jobs > 0 ? jobs : thread_count(control), control);
  (void)end_with(run, *study, write_study_report(*study, run.control("report")));
  if (outcome.failures.empty()) return 0;
  run.note_problems(outcome.failures);
  return kCannot;
}

int export_snakemake(CommandRun& run, const fs::path& file, const fs::path& folder) {
  const std::optional<StudyFolder> study = placed(run, file, folder);
  if (!study) return kInput;
  if (const std::vector<std::string> problems = write_plans(*study, run.stop()); !problems.empty()) {
    run.note_problems(problems);
    return kInput;
  }
  write_snakefile(*study);
  std::size_t num_cells = 0;
  for (const PlacedPart& part : study->parts) num_cells += part.cells.size();
  run.note(folder.string() + ": " + std::to_string(num_cells) + " cells; cd " + folder.string() +
           " && snakemake --profile profiles/local");
  if (run.line.common().json) run.report(Json{{"output", folder.string()}, {"cells", num_cells}}, "");
  return 0;
}

}  // namespace

int cmd_study(CommandRun& run) {
  std::string kind;
  fs::path study, output, snakemake;
  JobsOptions jobs;
  run.line.positional("KIND", "run (here), export (for Snakemake) or report (of what was made, wherever)", kind);
  run.line.choices(kKinds);
  const std::string asked = run.first_positional();
  run.line.positional("STUDY", asked == "report" ? "The folder of a study" : "A study file (docs/study.md)", study);
  if (asked == "run") {
    run.line.output("FOLDER", "Folder of the study: cells/NAME, report.html, report.json, a CSV a part", output);
    run.line.options(jobs);
  }
  if (asked == "export") {
    run.line.option("snakemake", "FOLDER", "Folder of the study, with a Snakefile and its profiles", snakemake);
    run.line.required();
  }
  run.line.without({"seed", "force"});
  run.line.example("study run study.json -o copper_on_all");
  run.line.example("study export study.json --snakemake copper_on_all");
  run.line.example("study report copper_on_all");
  if (!run.parse()) return 0;
  if (kind == "run") return run_here(run, study, output, jobs.jobs);
  if (kind == "export") return export_snakemake(run, study, snakemake);
  const StudyFolder folder = read_study_folder(study);
  return end_with(run, folder, write_study_report(folder, run.control("report")));
}

}  // namespace patinate::cli
