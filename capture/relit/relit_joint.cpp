// How the scans of all steps lie in the reference's frame, solved for together.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "capture/registration/joint_registration.h"
#include "capture/relit/relit_work.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

RelitPose pose_of(const JointRegistration& result, std::size_t scan) {
  const RegisteredScan& found = result.scans[scan];
  const double degrees = 180.0 / std::numbers::pi;
  RelitRegistration facts{
      .rms_mm = found.rms_residual,
      .overlap = found.overlap,
      .is_found_by_search = found.is_found_by_search,
      .stddev_deg = degrees * std::sqrt(std::max(0.0, found.covariance.topLeftCorner<3, 3>().trace())),
      .stddev_mm = std::sqrt(std::max(0.0, found.covariance.bottomRightCorner<3, 3>().trace())),
      .staying = found.staying,
      .ambiguous_deg = found.ambiguous_deg};
  for (const RegistrationEdge& edge : result.edges) {
    const bool is_of_scan = edge.target == static_cast<int>(scan) || edge.source == static_cast<int>(scan);
    if (edge.is_used && is_of_scan) facts.num_pairs += edge.pair.num_pairs;
  }
  for (const UnconstrainedDof& motion : found.unconstrained_dofs) facts.unconstrained_dofs.push_back(text_of(motion));
  return {.status = std::string(found.is_misled ? RelitPose::kMisled : name_of(found.status)),
          .is_accepted = found.is_misled || found.status == RegistrationStatus::Converged,
          .reference_from_scan = found.reference_from_scan,
          .registration = facts,
          .is_joint = true};
}

}  // namespace

std::vector<std::size_t> RelitWork::joint_steps() const {
  if (options.poses == RelitPoses::Each || !project.has_shape()) return {};
  std::vector<std::size_t> steps;
  for (std::size_t i = 0; i < project.steps.size(); ++i) {
    if (i == project.reference || !project.steps[i].reference_from_scan) steps.push_back(i);
  }
  if (steps.size() < 3) return {};
  return steps;
}

void run_relit_joint_poses(const RelitWork& work, const fs::path& folder, const RunControl& control) {
  const std::vector<std::size_t> steps = work.joint_steps();
  std::vector<PointCloud> scans;
  std::vector<std::optional<RigidTransform>> initial;
  for (const std::size_t i : steps) {
    scans.push_back(read_step_scan(work.project, work.project.steps[i]));
    initial.emplace_back(work.project.steps[i].initial.value_or(RigidTransform{}));  // As the scans lie.
  }
  const auto reference = std::find(steps.begin(), steps.end(), work.project.reference) - steps.begin();
  const JointRegistration result = [&] {
    try {
      return register_jointly(scans, initial, static_cast<int>(reference), work.options.registration, control);
    } catch (const InvalidInput& e) {
      throw IoError(work.project.file.string(), e.what());
    }
  }();
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (steps[k] == work.project.reference) continue;
    const RelitPose pose = pose_of(result, k);
    check_relit_pose(work, steps[k], pose);
    fs::create_directories((folder / relit_pose_file(steps[k])).parent_path());
    save_json(folder / relit_pose_file(steps[k]), to_json(pose));
  }
}

}  // namespace patinate::capture
