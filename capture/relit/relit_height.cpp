// Height of a step's scan over the reference's, in the reference view.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "capture/relief/relief_change.h"
#include "capture/relit/relit_work.h"
#include "capture/unlighting/unlight_work.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

/// Between the four pixels of the relief's view around a place, those that were measured and lie on the same surface.
float height_at(const Relief& relief, const Vec3& place) {
  const ReliefView& view = relief.view;
  const ReliefChange& change = relief.changes.front();
  const double u = (place - view.corner).dot(view.right) / view.texel,
               v = -(place - view.corner).dot(view.up) / view.texel;
  const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
  double sum = 0.0, weights = 0.0;
  for (int b = 0; b < 2; ++b) {
    for (int a = 0; a < 2; ++a) {
      if (!change.measured.contains(x + a, y + b) || change.measured.at(x + a, y + b) == 0) continue;
      if ((vector_of(relief.position_mm, x + a, y + b) - place).norm() > relief.window_mm) continue;
      const double weight = (a == 0 ? 1.0 - (u - x) : u - x) * (b == 0 ? 1.0 - (v - y) : v - y);
      sum += weight * static_cast<double>(change.change_mm.at(x + a, y + b));
      weights += weight;
    }
  }
  return weights > 0.0 ? static_cast<float>(sum / weights) : 0.0f;
}

}  // namespace

ImageF relit_height(const RelitWork& work, std::size_t index, const RelitPose& pose, const ScanView& reference,
                    const RunControl& control) {
  const RelitProject& project = work.project;
  ImageF height(project.width(), project.height());
  if (index == project.reference || !project.has_shape()) return height;
  if (pose.status == RelitPose::kMisled) {
    throw CannotComplete(work.step_name(index) + ": --heights: only " + fixed_percent_text(pose.registration->staying) +
                         " of its surface lies where the reference's does, so that nothing tells growth from motion; "
                         "give it a `transform` (of a mount, or by targets), or scan something that stays as well");
  }
  const Vec3 toward = -project.camera_mm.parameters().rotation.row(2).transpose();
  const std::vector<PointCloud> scans{read_step_scan(project, project.steps[project.reference]),
                                      read_step_scan(project, project.steps[index])};
  const std::array<RigidTransform, 2> poses{RigidTransform{}, pose.reference_from_scan};
  Relief relief;
  try {
    relief = measure_relief(scans, poses, 0, {},
                            {.toward = {toward.x(), toward.y(), toward.z()},
                             .keep_poses = project.steps[index].reference_from_scan.has_value() &&
                                           !project.steps[index].is_from_registration},
                            control);
  } catch (const InvalidInput& e) {
    throw CannotComplete(work.step_name(index) + ": --heights: " + e.what());
  }
  for (int y = 0; y < height.height(); ++y) {
    for (int x = 0; x < height.width(); ++x) {
      if (reference.seen.at(x, y) != 0) height.at(x, y) = height_at(relief, vector_of(reference.position_mm, x, y));
    }
  }
  return height;
}

}  // namespace patinate::capture
