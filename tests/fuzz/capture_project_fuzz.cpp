#include "capture/project/capture_project.h"
#include "capture/project/relit_project.h"
#include "patinate/image/image_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

namespace {

/// Two photographs beside the project, so that a good project is good.
void make_project_photographs() {
  static const bool is_made = [] {
    for (const char* name : {"2020-05-28.png", "2020-05-29.png"})
      write_codes(fuzz::fuzz_folder() / name, ImageU8(5, 4, 3));
    return true;
  }();
  (void)is_made;
}

}  // namespace

PATINATE_FUZZ_TARGET(capture_project) {
  make_project_photographs();
  const auto file = fuzz::fuzz_file("capture.json", bytes);
  if (capture::is_relit_capture(file)) {
    const capture::RelitProject relit = capture::read_relit_project(file);
    fuzz::require(!relit.steps.empty() && relit.reference < relit.steps.size(), "a project has a step");
    for (const capture::RelitStep& step : relit.steps)
      fuzz::require(step.ready || step.photos.size() == relit.lights.size(), "a step has one photograph a light");
    return;
  }
  const capture::CaptureProject project = capture::read_capture_project(file);
  fuzz::require(!project.frames.empty(), "a project has a frame");
  fuzz::require(project.width() >= 1 && project.height() >= 1, "a project has a size");
  (void)capture::read_photo(project, project.frames.front().file);
}
