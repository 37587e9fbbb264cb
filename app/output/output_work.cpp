#include "app/output/output_work.h"

#include "app/request/output_file.h"
#include "libcommon/core/input_watch.h"

namespace patinate::app {

std::vector<OutputFile> output_files(const std::vector<std::filesystem::path>& files) {
  std::vector<OutputFile> outputs;
  for (const std::filesystem::path& file : files) outputs.push_back(output_file(file));
  return outputs;
}

std::vector<OutputFile> files_of(const OutputWork& work) {
  std::vector<OutputFile> files{{.path = work.output, .existing_key = work.existing_key}};
  files.insert(files.end(), work.beside.begin(), work.beside.end());
  return files;
}

void make_pieces(const OutputWork& work, const std::vector<std::size_t>& todo, const RunControl& control) {
  for (std::size_t k = 0; k < todo.size(); ++k) {
    control.throw_if_stopped();
    const InputStep step;
    work.pieces[todo[k]].make(control.silent());
    control.report((static_cast<double>(k) + 1.0) / static_cast<double>(todo.size()));
  }
}

JobStatus make_output(const OutputWork& work, bool force, const RunControl& control) {
  const JobOptions options{.force = force};
  if (work.plan) return run_job(*work.plan, options, control);
  if (work.pieces.empty()) {
    const JobStatus status = check_output_files(files_of(work), work.key, options);
    if (status == JobStatus::Done) work.make(control);
    return status;
  }
  std::vector<std::size_t> todo;  // All are looked at before anything is written.
  for (std::size_t i = 0; i < work.pieces.size(); ++i) {
    control.throw_if_stopped();
    const OutputPiece& piece = work.pieces[i];
    if (check_output_files(output_files(piece.files), piece.key, options) == JobStatus::Done) todo.push_back(i);
  }
  make_pieces(work, todo, control);
  return todo.empty() ? JobStatus::UpToDate : JobStatus::Done;
}

}  // namespace patinate::app
