#include "tools/patinate/services/output_work.h"

#include "tools/patinate/command_line/output_file.h"

namespace patinate::cli {

namespace {

RunControl without_progress(RunControl control) {
  control.on_progress = {};
  return control;
}

}  // namespace

std::pair<std::filesystem::path, std::string> decisive_file(const std::vector<std::filesystem::path>& files,
                                                            const std::string& key) {
  const std::filesystem::path* decisive = &files.front();
  std::string decisive_key = image_file_key(files.front());
  const auto rank = [&](const std::filesystem::path& file, const std::string& existing) {
    std::error_code error;
    return !std::filesystem::exists(file, error) ? 1 : existing == key ? 0 : 2;
  };
  for (const std::filesystem::path& file : files) {
    const std::string existing = image_file_key(file);
    if (rank(file, existing) <= rank(*decisive, decisive_key)) continue;
    decisive = &file;
    decisive_key = existing;
  }
  return {*decisive, decisive_key};
}

void make_pieces(const OutputWork& work, const std::vector<std::size_t>& todo, const RunControl& control) {
  for (std::size_t k = 0; k < todo.size(); ++k) {
    control.throw_if_stopped();
    work.pieces[todo[k]].make(without_progress(control));
    control.report((static_cast<double>(k) + 1.0) / static_cast<double>(todo.size()));
  }
}

JobStatus make_output(const OutputWork& work, bool force, const RunControl& control) {
  const JobOptions options{.force = force};
  if (work.plan) return run_job(*work.plan, options, control);
  if (work.pieces.empty()) {
    const JobStatus status = check_output_file(work.output, work.existing_key, work.key, options);
    if (status == JobStatus::Done) work.make(control);
    return status;
  }
  std::vector<std::size_t> todo;  // All are looked at before anything is written.
  for (std::size_t i = 0; i < work.pieces.size(); ++i) {
    control.throw_if_stopped();
    const auto [file, existing_key] = decisive_file(work.pieces[i].files, work.pieces[i].key);
    if (check_output_file(file, existing_key, work.pieces[i].key, options) == JobStatus::Done) todo.push_back(i);
  }
  make_pieces(work, todo, control);
  return todo.empty() ? JobStatus::UpToDate : JobStatus::Done;
}

}  // namespace patinate::cli
