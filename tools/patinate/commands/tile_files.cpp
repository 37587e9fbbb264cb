#include "tools/patinate/commands/tile_files.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/request/output_file.h"
#include "patinate/atlas/sheet.h"

namespace patinate::cli {

std::vector<std::filesystem::path> tile_files(const std::filesystem::path& output,
                                              const std::vector<std::string>& tile_names) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : tile_names) files.push_back(tile_path(output, name));
  return files;
}

namespace {

PlannedWork planned_pieces(const std::filesystem::path& output, const std::string& key,
                           const std::vector<app::OutputPiece>& pieces, const JobOptions& options) {
  PlannedWork work{.output = output, .key = key, .depends_on = {}, .items = {}};
  for (const app::OutputPiece& piece : pieces) {
    const bool is_made = check_output_files(app::output_files(piece.files), piece.key, options) == JobStatus::UpToDate;
    work.items.push_back({.name = piece.files.front().filename().string(),
                          .key = piece.key,
                          .outputs = piece.files,
                          .waits_for = {},
                          .is_finished = is_made});
  }
  work.is_up_to_date = work.unfinished().empty();
  return work;
}

/// Items of a plan that are asked for. @returns nothing when nothing is to be made of them.
std::optional<std::vector<std::size_t>> answered_pieces(CommandRun& run, const std::filesystem::path& output,
                                                        const std::string& key,
                                                        const std::vector<app::OutputPiece>& pieces) {
  using Wanted = PlanRequest::Wanted;
  PlanRequest& request = *run.request();
  if (request.identity) require_same_work(*request.identity, key, {});
  PlannedWork work = planned_pieces(output, key, pieces, run.job_options());
  if (request.wanted == Wanted::Description) {
    request.work = std::move(work);
    return std::nullopt;
  }
  if (request.wanted == Wanted::Join) require_finished(work);
  const std::vector<std::size_t> asked = asked_items(request, pieces.size());
  std::vector<std::size_t> todo;
  std::copy_if(asked.begin(), asked.end(), std::back_inserter(todo),
               [&](std::size_t i) { return !work.items[i].is_finished; });
  return todo;
}

}  // namespace

std::optional<JobStatus> check_tile_files(CommandRun& run, const std::vector<std::filesystem::path>& files,
                                          const std::string& key) {
  return run.check_files(app::output_files(files), key);
}

std::optional<std::vector<std::size_t>> unfinished_pieces(CommandRun& run, const std::filesystem::path& output,
                                                          const std::string& key,
                                                          const std::vector<app::OutputPiece>& pieces) {
  if (run.request() != nullptr) return answered_pieces(run, output, key, pieces);
  std::vector<std::size_t> todo;
  if (run.line.common().dry_run) {
    // Tells of the first that would be made.
    const auto is_open = [](const app::OutputPiece& piece) {
      return std::any_of(piece.files.begin(), piece.files.end(),
                         [&](const auto& file) { return app::written_key(file) != piece.key; });
    };
    const auto first = std::find_if(pieces.begin(), pieces.end(), is_open);
    const app::OutputPiece& told = first == pieces.end() ? pieces.front() : *first;
    (void)check_tile_files(run, told.files, told.key);
    return std::nullopt;
  }
  for (std::size_t i = 0; i < pieces.size(); ++i) {  // All are looked at before anything is written.
    if (*check_tile_files(run, pieces[i].files, pieces[i].key) == JobStatus::Done) todo.push_back(i);
  }
  return todo;
}

void report_tile_files(CommandRun& run, JobStatus status, const std::filesystem::path& output,
                       const std::vector<std::filesystem::path>& files, Json more) {
  if (files.size() == 1) return run.report_output(status, files.front(), more);
  Json names = Json::array();
  for (const std::filesystem::path& file : files) names.push_back(file.string());
  more["files"] = names;
  run.report_output(status, tile_path(output, "<UDIM>"), more);
}

}  // namespace patinate::cli
