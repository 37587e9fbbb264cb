#include "tools/patinate/study/study_plans.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "tools/patinate/command_line/repeating_command.h"
#include "tools/patinate/study/step_process.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

std::string key_of(const fs::path& plan) {
  std::error_code error;
  return fs::is_regular_file(plan, error) ? load_json(plan).value("key", "") : "";
}

/// @returns what is wrong, "" if nothing.
std::string write_plan(const StudyFolder& study, const StudyStep& step, const PlacedCell& cell,
                       const std::string& command, const std::stop_token& stop) {
  const fs::path plan = fs::path("plans") / step.name / (cell.name + ".json");
  const fs::path fresh = fs::path("plans") / step.name / ("." + cell.name + ".tmp");
  const int code =
      run_step(this_program() + " plan " + command + " --force --quiet --json > " + shell_word(fresh.generic_string()),
               study.path, log_file(step, cell), stop);
  std::error_code error;
  if (stop.stop_requested() || code == kStepInterrupted) throw Canceled();
  if (code != 0) {
    fs::remove(study.path / fresh, error);
    fs::remove(study.path / done_file(step, cell), error);
    const StepState state = step_state(study, step, cell);
    return state.message.empty() ? "ended with exit code " + std::to_string(code) : state.message;
  }
  if (key_of(study.path / fresh) != key_of(study.path / plan)) {
    fs::remove_all(study.path / "items" / step.name / cell.name, error);
    fs::remove(study.path / done_file(step, cell), error);
  }
  fs::rename(study.path / fresh, study.path / plan);
  return "";
}

}  // namespace

std::vector<std::string> write_plans(const StudyFolder& study, const std::stop_token& stop) {
  std::vector<std::string> problems;
  for (const PlacedPart& part : study.parts) {
    for (std::size_t s = 0; s < part.steps.size(); ++s) {
      if (!part.steps[s].in_items) continue;
      fs::create_directories(study.path / "plans" / part.steps[s].name);
      for (const PlacedCell& cell : part.cells) {
        const std::string problem = write_plan(study, part.steps[s], cell, cell.commands[s], stop);
        if (!problem.empty()) problems.push_back(cell.name + ": " + part.steps[s].name + ": " + problem);
      }
    }
  }
  return problems;
}

}  // namespace patinate::cli
