// How the scan of a step lies in the reference's frame.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "capture/ingest/relit_work.h"
#include "libcommon/core/error.h"
#include "libcommon/core/text.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

Json matrix_json(const RigidTransform& transform) {
  const Eigen::Matrix4d m = transform.matrix();
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

Json facts_of(const PairRegistration& r) {
  Json facts{{"rms_mm", r.rms_residual}, {"registration_overlap", r.overlap}, {"pairs", r.num_pairs}, {"found_by_search", r.is_found_by_search}};
  const double degrees = 180.0 / std::numbers::pi;
  facts["stddev_deg"] = degrees * std::sqrt(std::max(0.0, r.covariance.topLeftCorner<3, 3>().trace()));
  facts["stddev_mm"] = std::sqrt(std::max(0.0, r.covariance.bottomRightCorner<3, 3>().trace()));
  facts["free_motions"] = Json::array();
  for (const FreeMotion& motion : r.free_motions) facts["free_motions"].push_back(text_of(motion));
  return facts;
}

RelitPose find_pose(const RelitWork& work, std::size_t index, const RunControl& control) {
  const RelitProject& project = work.project;
  const RelitStep& step = project.steps[index];
  if (step.reference_from_scan) return {"given", true, *step.reference_from_scan};
  if (index == project.reference || !step.has_shape()) return {"reference", true, RigidTransform{}};
  const PointCloud target = read_step_scan(project, project.steps[project.reference]), source = read_step_scan(project, step);
  const PairRegistration found = [&] {
    try {
      return register_pair(target, source, step.initial.value_or(RigidTransform{}), work.options.registration, control);
    } catch (const IoError&) {
      throw;
    } catch (const InvalidInput& e) {
      throw IoError(project.file.string(), work.step_name(index) + ": " + e.what());
    }
  }();
  RelitPose pose{std::string(name_of(found.status)), found.status == RegistrationStatus::Converged, found.target_from_source, facts_of(found).dump()};
  if (pose.is_accepted || work.options.accept_failed) return pose;
  std::string open;
  for (const FreeMotion& motion : found.free_motions) open += (open.empty() ? "; free: " : ", ") + text_of(motion);
  throw CannotComplete(work.step_name(index) + ": its scan cannot be registered: " + pose.status + " (overlap " + short_number_text(std::round(100.0 * found.overlap)) +
                       " %, RMS " + short_number_text(rounded(found.rms_residual, 3)) + " mm" + open + "); give it `initial` or `transform`, or leave it out with --accept-failed");
}

}  // namespace

void run_relit_pose(const RelitWork& work, std::size_t index, const fs::path& folder, const RunControl& control) {
  const RelitPose pose = find_pose(work, index, control);
  Json json{{"status", pose.status}, {"is_accepted", pose.is_accepted}, {"reference_from_scan", matrix_json(pose.reference_from_scan)}, {"facts", Json::parse(pose.facts)}};
  fs::create_directories((folder / relit_pose_file(index)).parent_path());
  save_json(folder / relit_pose_file(index), json);
  control.report(1.0);
}

RelitPose read_relit_pose(const RelitWork&, std::size_t index, const fs::path& folder) {
  const Json json = load_json(folder / relit_pose_file(index));
  Eigen::Matrix4d matrix;
  for (Eigen::Index r = 0; r < 4; ++r) {
    for (Eigen::Index c = 0; c < 4; ++c) matrix(r, c) = json.at("reference_from_scan").at(static_cast<std::size_t>(r)).at(static_cast<std::size_t>(c)).get<double>();
  }
  return {json.at("status").get<std::string>(), json.at("is_accepted").get<bool>(), {matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>()}, json.at("facts").dump()};
}

}  // namespace patinate
