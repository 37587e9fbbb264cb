// How the scan of a step lies in the reference's frame.
#include <nlohmann/json.hpp>

#include "capture/ingest/relit_work.h"
#include "libcommon/core/error.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

Json matrix_json(const RigidTransform& transform) {
  const Eigen::Matrix4d m = transform.matrix();
  Json rows = Json::array();
  for (Eigen::Index r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

RelitPose find_pose(const RelitWork& work, std::size_t index, const RunControl&) {
  const RelitStep& step = work.project.steps[index];
  if (step.reference_from_scan) return {"given", true, *step.reference_from_scan};
  if (index == work.project.reference || !step.has_shape()) return {"reference", true, RigidTransform{}};
  throw InvalidInput(work.step_name(index) + ": has no `transform`");
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
