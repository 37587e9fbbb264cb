#include "tools/patinate/study/study_run.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <system_error>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"
#include "tools/patinate/study/step_process.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Runs the steps of one cell, until one fails.
void run_cell(const StudyFolder& study, const PlacedPart& part, const PlacedCell& cell, int num_threads,
              const RunControl& control, StudyOutcome& outcome, std::mutex& mutex) {
  for (std::size_t s = 0; s < part.steps.size(); ++s) {
    control.throw_if_stopped();
    const StudyStep& step = part.steps[s];
    std::error_code error;
    fs::remove(study.path / done_file(step, cell), error);
    const int code = run_step(
        this_program() + " run " + cell.commands[s] + " --force --quiet --threads " + std::to_string(num_threads),
        study.path, log_file(step, cell), control.stop);
    if (control.stop.stop_requested() || code == kStepInterrupted) throw Canceled();
    if (code == 0) {
      write_atomically(study.path / done_file(step, cell), "");
      const std::lock_guard lock(mutex);
      ++outcome.num_done;
      continue;
    }
    StepState state = step_state(study, step, cell);
    if (state.status != StepStatus::Failed) {
      // Ended without a word, as by the kernel when memory is out.
      state.message = "ended with exit code " + std::to_string(code) + " and said nothing; was there enough memory?";
      std::ofstream(study.path / log_file(step, cell), std::ios::app) << "patinate: error: " << state.message << "\n";
    }
    const std::lock_guard lock(mutex);
    outcome.failures.push_back(cell.name + ": " + step.name + ": " + state.message);
    return;
  }
}

}  // namespace

StudyOutcome run_study(const StudyFolder& study, int num_jobs, const RunControl& control) {
  std::vector<std::pair<const PlacedPart*, const PlacedCell*>> cells;
  for (const PlacedPart& part : study.parts) {
    for (const PlacedCell& cell : part.cells) cells.emplace_back(&part, &cell);
  }
  StudyOutcome outcome;
  std::mutex mutex;
  std::size_t num_ended = 0;
  RunControl workers;
  workers.stop = control.stop;
  workers.num_threads = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(num_jobs), cells.size()));
  const int num_threads = std::max(1, thread_count(control) / std::max(1, workers.num_threads));
  parallel_for(static_cast<std::int64_t>(cells.size()), 1, workers, [&](std::int64_t begin, std::int64_t) {
    const auto& [part, cell] = cells[static_cast<std::size_t>(begin)];
    run_cell(study, *part, *cell, num_threads, control, outcome, mutex);
    const std::lock_guard lock(mutex);
    control.report(static_cast<double>(++num_ended) / static_cast<double>(cells.size()));
  });
  std::sort(outcome.failures.begin(), outcome.failures.end());
  return outcome;
}

}  // namespace patinate::cli
