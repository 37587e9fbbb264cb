#include "capture/unlighting/unlight_step.h"
#include "patinate/image/image_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

namespace {

/// Photographs beside the step, so that a good step is good.
void make_step_photographs() {
  static const bool is_made = [] {
    for (const char* name : {"light0.png", "light1.png", "light2.png"})
      write_codes(fuzz::fuzz_folder() / name, ImageU8(5, 4, 3, 100));
    write_codes(fuzz::fuzz_folder() / "mask.png", ImageU8(5, 4, 1, 255));
    return true;
  }();
  (void)is_made;
}

}  // namespace

/// Input of `unlight`.
PATINATE_FUZZ_TARGET(unlight_step) {
  make_step_photographs();
  const capture::UnlightStep step = capture::read_unlight_step(fuzz::fuzz_file("step.json", bytes));
  fuzz::require(!step.photos.empty() && step.photos.size() == step.lights.size(), "a step has one photograph a light");
  fuzz::require(step.width == 5 && step.height == 4 && step.mm_per_unit > 0.0,
                "a step has the photographs' size, and a unit");
  fuzz::require(!step.scan || step.camera_mm, "a scan is seen by a camera");
  if (step.scan) return;
  const capture::UnlightScene scene = capture::load_unlight_scene(step);
  fuzz::require(scene.input.photos.size() == step.photos.size(), "every photograph is decoded");
}
