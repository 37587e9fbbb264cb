#include "patinate/capture/make_history.h"

#include <algorithm>

#include "capture/plan_history.h"
#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "libcommon/job/job.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

IngestOptions ingest_options(const MakeHistoryOptions& options) {
  IngestOptions ingest;
  ingest.add_progress = options.add_progress;
  ingest.repair.stabilize = options.stabilize;
  ingest.repair.deflicker = options.deflicker;
  ingest.repair.flat_field = options.flat_field;
  ingest.repair.highlights = options.keep_highlights ? HighlightRule::Keep : HighlightRule::Mask;
  return ingest;
}

void refuse_fixed_camera_options(const IngestOptions& options, const std::filesystem::path& file) {
  const auto given = option_values(options), otherwise = option_values(IngestOptions{});
  for (std::size_t i = 0; i < given.size(); ++i) {
    const auto& [name, value] = given[i];
    if (value != otherwise[i].second &&
        std::find(kFixedCameraOptions.begin(), kFixedCameraOptions.end(), name) != kFixedCameraOptions.end())
      throw InvalidInput(name + ": is for captures of a fixed camera; " + file.string() + " is of kind relit");
  }
}

}  // namespace

JobPlan plan_history(const std::filesystem::path& capture, const std::filesystem::path& output, IngestOptions options,
                     RelitOptions relit) {
  const std::filesystem::path file = capture_file(capture);
  if (is_relit_capture(file)) {
    refuse_fixed_camera_options(options, file);
    relit.scan = options.scan;
    relit.fill = options.repair.fill;
    relit.progress = options.progress;
    return plan_relit_ingest(read_relit_project(file), relit, output);
  }
  options.accept_failed = relit.accept_failed;
  return plan_ingest(read_capture_project(file, options.align), options, output);
}

void make_history(const std::filesystem::path& capture, const std::filesystem::path& output,
                  const MakeHistoryOptions& options, const RunControl& control) {
  run_job(plan_history(capture, output, ingest_options(options), {}), {.force = options.force}, control);
}

}  // namespace patinate::capture
