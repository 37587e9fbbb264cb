#include "tools/patinate/services/output_command.h"

#include <nlohmann/json.hpp>

#include "tools/patinate/services/movie_frames.h"
#include "tools/patinate/services/tile_files.h"

namespace patinate::cli {

namespace {

/// Nothing when the command has no more to do.
std::optional<JobStatus> made(CommandRun& run, const OutputWork& work) {
  if (work.plan) return run.make_folder(*work.plan, work.label);
  if (work.movie && run.request() != nullptr) return answer_movie(run, *work.movie);
  if (work.pieces.empty()) {
    const std::optional<JobStatus> status = run.check_files(files_of(work), work.key);
    if (status == JobStatus::Done) work.make(run.control(work.label));
    return status;
  }
  const auto todo = unfinished_pieces(run, work.output, work.key, work.pieces);
  if (!todo) return std::nullopt;
  make_pieces(work, *todo, run.control(work.label));
  return todo->empty() ? JobStatus::UpToDate : JobStatus::Done;
}

}  // namespace

int run_output(CommandRun& run, const OutputWork& work) {
  run.notes(work.notes);
  if (const std::optional<JobStatus> status = made(run, work))
    run.report_output(*status, work.output, work.report ? *work.report : Json::object());
  return 0;
}

}  // namespace patinate::cli
