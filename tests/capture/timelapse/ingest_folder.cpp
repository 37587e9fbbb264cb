#include "tests/capture/timelapse/ingest_folder.h"

#include "tests/support/errors.h"

namespace patinate::testing_support {

HistoryReader ingest(const std::filesystem::path& folder, const capture::IngestOptions& options,
                     const RunControl& control) {
  const capture::CaptureProject project = capture::read_capture_project(folder / "capture.json");
  (void)run_job(capture::plan_ingest(project, options, folder / "out"), {}, control);
  return HistoryReader(folder / "out");
}

std::string ingest_error(const std::filesystem::path& folder, const capture::IngestOptions& options) {
  return error_of([&] { (void)ingest(folder, options); });
}

}  // namespace patinate::testing_support
