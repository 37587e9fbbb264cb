#include "patinate/capture/make_history.h"

#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "capture/relit/relit_ingest.h"
#include "capture/timelapse/ingest.h"
#include "libcommon/job/job.h"

namespace patinate::capture {

namespace {

JobPlan plan_history(const std::filesystem::path& file, const std::filesystem::path& output,
                     const MakeHistoryOptions& options) {
  if (is_relit_capture(file)) return plan_relit_ingest(read_relit_project(file), {}, output);
  IngestOptions ingest;
  ingest.add_progress = options.add_progress;
  ingest.repair.stabilize = options.stabilize;
  ingest.repair.deflicker = options.deflicker;
  ingest.repair.flat_field = options.flat_field;
  ingest.repair.highlights = options.keep_highlights ? HighlightRule::Keep : HighlightRule::Mask;
  return plan_ingest(read_capture_project(file), ingest, output);
}

}  // namespace

void make_history(const std::filesystem::path& capture, const std::filesystem::path& output,
                  const MakeHistoryOptions& options, const RunControl& control) {
  run_job(plan_history(capture_file(capture), output, options), {.force = options.force}, control);
}

}  // namespace patinate::capture
