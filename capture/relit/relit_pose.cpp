// How the scan of a step lies in the reference's frame.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "capture/registration/changed_surface.h"
#include "capture/registration/reference_methods.h"
#include "capture/registration/surfels.h"
#include "capture/relit/relit_work.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

RelitRegistration facts_of(const PairRegistration& r) {
  const double degrees = 180.0 / std::numbers::pi;
  const Matrix6 covariance = r.covariance + r.misjudged * r.misjudged.transpose();
  RelitRegistration facts{.rms_mm = r.rms_residual,
                          .overlap = r.overlap,
                          .num_pairs = r.num_pairs,
                          .is_found_by_search = r.is_found_by_search,
                          .stddev_deg = degrees * std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace())),
                          .stddev_mm = std::sqrt(std::max(0.0, covariance.bottomRightCorner<3, 3>().trace())),
                          .staying = r.staying,
                          .ambiguous_deg = r.ambiguous_deg};
  for (const UnconstrainedDof& motion : r.unconstrained_dofs) facts.unconstrained_dofs.push_back(text_of(motion));
  return facts;
}

/// Where the scan lies, by the method that the options name, from `initial` or as the two lie.
PairRegistration registered(const PointCloud& reference, const PointCloud& scan, const RelitStep& step,
                            const RegistrationOptions& options, const RunControl& control) {
  const RigidTransform start = step.initial.value_or(RigidTransform{});
  if (options.method == RegistrationMethod::Symmetric) return register_pair(reference, scan, start, options, control);
  return register_pair_with_pcl(reference, scan, start, options, control);
}

RelitPose find_pose(const RelitWork& work, std::size_t index, const RunControl& control) {
  const RelitProject& project = work.project;
  const RelitStep& step = project.steps[index];
  if (step.reference_from_scan) {
    return {.status = step.is_from_registration ? "given by a registration" : "given",
            .is_accepted = true,
            .reference_from_scan = *step.reference_from_scan};
  }
  if (index == project.reference || !step.has_shape())
    return {.status = "reference", .is_accepted = true, .reference_from_scan = {}};
  const PointCloud target = read_step_scan(project, project.steps[project.reference]),
                   source = read_step_scan(project, step);
  const PairRegistration found = [&] {
    try {
      return registered(target, source, step, work.options.registration, control);
    } catch (const InvalidInput& e) {
      throw IoError(project.file.string(), work.step_name(index) + ": " + e.what());
    }
  }();
  RelitPose pose{std::string(name_of(found.status)), found.status == RegistrationStatus::Converged,
                 found.target_from_source, facts_of(found)};
  if (pose.is_accepted && is_misled_by_change(found.staying, found.misjudged, point_spacing(target.points)))
    pose.status = RelitPose::kMisled;
  check_relit_pose(work, index, pose);
  return pose;
}

}  // namespace

void check_relit_pose(const RelitWork& work, std::size_t index, const RelitPose& pose) {
  if (pose.is_accepted || work.options.accept_failed) return;
  const RelitRegistration found = pose.registration.value_or(RelitRegistration{});
  std::string open;
  for (const std::string& motion : found.unconstrained_dofs)
    open += (open.empty() ? "; unconstrained: " : ", ") + motion;
  throw CannotComplete(work.step_name(index) + ": its scan cannot be registered: " + pose.status + " (overlap " +
                       short_number_text(std::round(100.0 * found.overlap)) + " %, RMS " +
                       short_number_text(rounded(found.rms_mm, 3)) + " mm" + open +
                       "); give it `initial` or `transform`, or exclude it with --accept-failed");
}

void run_relit_pose(const RelitWork& work, std::size_t index, const fs::path& folder, const RunControl& control) {
  const RelitPose pose = find_pose(work, index, control);
  fs::create_directories((folder / relit_pose_file(index)).parent_path());
  save_json(folder / relit_pose_file(index), to_json(pose));
  control.report(1.0);
}

RelitPose read_relit_pose(std::size_t index, const fs::path& folder) {
  return relit_pose(load_json(folder / relit_pose_file(index)));
}

}  // namespace patinate::capture
