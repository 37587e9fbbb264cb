#include "tools/patinate/commands/output_command.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "app/output/output_work.h"
#include "app/request/output_file.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/command_run.h"
#include "tools/patinate/commands/tile_files.h"

namespace patinate::cli {

namespace {

namespace fs = std::filesystem;

fs::path items_folder(const app::MovieFrames& movie) { return movie.output.string() + ".items"; }

fs::path frame_file(const app::MovieFrames& movie, std::size_t i) {
  return items_folder(movie) / (zero_padded(i, 5) + ".png");
}

PlannedWork planned_frames(const app::MovieFrames& movie) {
  PlannedWork work{.output = movie.output, .key = movie.key, .depends_on = {}, .items = {}};
  work.has_join = true;
  work.join_weight = 0.1 * static_cast<double>(movie.keys.size());
  work.is_up_to_date = app::written_key(movie.output) == movie.key;
  for (std::size_t i = 0; i < movie.keys.size(); ++i) {
    const fs::path file = frame_file(movie, i);
    work.items.push_back({.name = file.filename().string(),
                          .key = movie.keys[i],
                          .outputs = {file},
                          .waits_for = {},
                          .is_finished = work.is_up_to_date || app::image_file_key(file) == movie.keys[i]});
  }
  return work;
}

/// @returns how many were made.
std::size_t make_frames(const app::MovieFrames& movie, const PlannedWork& work, const std::vector<std::size_t>& items,
                        const RunControl& control) {
  const RunControl silent = control.silent();
  std::size_t num_made = 0;
  fs::create_directories(items_folder(movie));
  for (std::size_t k = 0; k < items.size(); ++k) {
    if (!work.items[items[k]].is_finished) {
      write_codes(frame_file(movie, items[k]), movie.codes(static_cast<int>(items[k]), silent), movie.keys[items[k]]);
      ++num_made;
    }
    control.report((static_cast<double>(k) + 1.0) / static_cast<double>(items.size()));
  }
  return num_made;
}

void encode(const app::MovieFrames& movie, const RunControl& control) {
  const auto codes = [&](int i) {
    const fs::path file = frame_file(movie, static_cast<std::size_t>(i));
    if (app::image_file_key(file) != movie.keys[i])
      throw CannotComplete(file.string() + ": is damaged, or was removed meanwhile; run its item again");
    return srgb8_from_linear(read_color(file));  // Gives back the codes that were written.
  };
  write_coded_movie(movie.output, static_cast<int>(movie.keys.size()), codes, movie.options, movie.key, control);
  std::error_code error;
  fs::remove_all(items_folder(movie), error);
}

/// Answers `plan`, `run` and `join` (run.request()). Pictures are kept as PNGs in OUT.items until the movie is there;
/// those that are finished are not made again, and two processes may make the same at once.
/// @returns nothing unless the movie is there in the end.
/// @throws CannotComplete naming the pictures that a join lacks, or where another movie is in the way.
std::optional<JobStatus> answer_movie(CommandRun& run, const app::MovieFrames& movie) {
  using Wanted = PlanRequest::Wanted;
  PlanRequest& request = *run.request();
  if (request.identity) require_same_work(*request.identity, movie.key, {});
  const JobStatus status = check_output_file(movie.output, app::written_key(movie.output), movie.key,
                                             run.job_options());  // Files in the way.
  PlannedWork work = planned_frames(movie);
  if (request.wanted == Wanted::Description) {
    request.work = std::move(work);
    return std::nullopt;
  }
  if (request.wanted == Wanted::Items) {
    const std::vector<std::size_t> items = asked_items(request, work.items.size());
    run.report_items(movie.output,
                     status == JobStatus::UpToDate ? 0 : make_frames(movie, work, items, run.control(movie.label)),
                     items.size());
    return std::nullopt;
  }
  if (status == JobStatus::UpToDate) return status;
  const RunControl control = run.control(movie.label);
  if (request.wanted == Wanted::Join) {
    require_finished(work);
    encode(movie, control);
    return status;
  }
  make_frames(movie, work, work.unfinished(), control.part(0.0, 0.9));
  encode(movie, control.part(0.9, 1.0));
  return status;
}

/// Nothing when the command has no more to do.
std::optional<JobStatus> made(CommandRun& run, const app::OutputWork& work) {
  if (work.plan) return run.make_folder(*work.plan, work.label);
  if (work.movie && run.request() != nullptr) return answer_movie(run, *work.movie);
  if (work.pieces.empty()) {
    const std::optional<JobStatus> status = run.check_files(app::files_of(work), work.key);
    if (status == JobStatus::Done) work.make(run.control(work.label));
    return status;
  }
  const auto todo = unfinished_pieces(run, work.output, work.key, work.pieces);
  if (!todo) return std::nullopt;
  app::make_pieces(work, *todo, run.control(work.label));
  return todo->empty() ? JobStatus::UpToDate : JobStatus::Done;
}

}  // namespace

int run_output(CommandRun& run, const app::OutputWork& work) {
  const std::optional<JobStatus> status = made(run, work);
  run.notes(work.notes);  // Behind the work: an output that is refused has one line.
  if (status) run.report_output(*status, work.output, work.report ? *work.report : Json::object());
  return 0;
}

}  // namespace patinate::cli
