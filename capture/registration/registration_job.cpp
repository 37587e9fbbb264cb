#include "capture/registration/registration_job.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/registration/registration_io.h"
#include "capture/registration/registration_picture.h"
#include "capture/registration/surfels.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 1;  ///< Raised when the same input gives other poses.

bool is_scan_name(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".ply" || extension == ".pcd" || extension == ".obj";
}

std::string numbers_text(const RigidTransform& t) {
  std::string text;
  for (const double value : t.matrix().reshaped()) text += number_text(value) + " ";
  return text;
}

JobInputs inputs_of(const RegistrationTask& task, const std::vector<std::string>& names) {
  JobInputs inputs("register", kStageVersion);
  for (std::size_t k = 0; k < task.files.size(); ++k) {
    inputs.add_file("scan", task.files[k]);
    inputs.add_value("name of " + names[k], names[k]);
    if (!task.initial.empty() && task.initial[k])
      inputs.add_value("initial pose of " + names[k], numbers_text(*task.initial[k]));
  }
  inputs.add_value("--reference", names[task.reference]);
  inputs.add_value("--unit", task.unit);
  inputs.add_options(option_values(task.options));
  inputs.add_value("--accept-failed", task.accept_failed ? "true" : "false");
  inputs.add_value("--merged", task.write_merged ? "true" : "false");
  inputs.add_value("--moved", task.write_scans ? "true" : "false");
  return inputs;
}

/// One line about the first scan that has no certain place.
void check_all_placed(const JointRegistration& result, const std::vector<std::string>& names) {
  for (std::size_t k = 0; k < names.size(); ++k) {
    const RegisteredScan& s = result.scans[k];
    if (s.status == RegistrationStatus::Converged) continue;
    std::string text = names[k] + ": " + std::string(name_of(s.status));
    if (!s.unconstrained_dofs.empty())
      text += ": its shape does not constrain a " + text_of(s.unconstrained_dofs.front());
    if (s.unconstrained_dofs.empty() && s.partner >= 0) text += " with " + names[s.partner];
    if (s.unconstrained_dofs.empty()) text += " (overlap " + short_number_text(rounded(s.overlap, 2)) + ")";
    throw CannotComplete(text + "; --accept-failed continues without it, --initial FILE.conf says where scans stand");
  }
}

std::vector<PointCloud> read_scans(const RegistrationTask& task) {
  std::vector<PointCloud> scans;
  for (const fs::path& file : task.files) {
    scans.push_back(read_point_cloud(file));
    try {
      (void)point_spacing(scans.back().points);
    } catch (const InvalidInput& e) {
      throw IoError(file.string(), e.what());
    }
  }
  return scans;
}

PointCloud merged_cloud(const std::vector<PointCloud>& scans, const JointRegistration& result) {
  PointCloud merged;
  const bool has_colors =
      std::all_of(scans.begin(), scans.end(), [](const PointCloud& s) { return s.colors.size() == s.points.size(); });
  for (std::size_t k = 0; k < scans.size(); ++k) {
    if (!is_placed(result.scans[k])) continue;
    for (const Vec3& p : scans[k].points) merged.points.push_back(result.scans[k].reference_from_scan.apply(p));
    if (has_colors) merged.colors.insert(merged.colors.end(), scans[k].colors.begin(), scans[k].colors.end());
  }
  return merged;
}

void write_files(const fs::path& folder, const RegistrationTask& task, const std::vector<std::string>& names,
                 const std::vector<PointCloud>& scans, const JointRegistration& result, const fs::path& output,
                 const std::string& key) {
  std::vector<ScanPose> poses;
  std::vector<RigidTransform> before, after;
  std::vector<PointCloud> placed;
  const std::optional<RigidTransform> world = task.initial.empty() ? std::nullopt : task.initial[task.reference];
  for (std::size_t k = 0; k < scans.size(); ++k) {
    if (!is_placed(result.scans[k])) continue;
    poses.push_back({names[k], result.scans[k].reference_from_scan});
    const RigidTransform start = task.initial.empty() ? RigidTransform{} : task.initial[k].value_or(RigidTransform{});
    before.push_back(world ? world->inverse() * start : start);
    after.push_back(result.scans[k].reference_from_scan);
    placed.push_back(scans[k]);
  }
  const bool has_odd_name = std::any_of(
      names.begin(), names.end(), [](const std::string& n) { return n.find_first_of(" \t#") != std::string::npos; });
  if (!has_odd_name) write_scan_poses(folder / "poses.conf", poses);
  write_srgb8(folder / "registration.png", registration_picture(placed, before, after));
  if (task.write_merged) write_point_cloud(folder / "merged.ply", merged_cloud(scans, result));
  for (std::size_t k = 0; task.write_scans && k < scans.size(); ++k) {
    if (!is_placed(result.scans[k])) continue;
    const fs::path file = (folder / "scans" / names[k]).replace_extension(".ply");
    fs::create_directories(file.parent_path());
    write_point_cloud(file, moved(scans[k], result.scans[k].reference_from_scan));
  }
  Json json = registration_json(result, names, task.reference, task.unit, task.options.method, key);
  const fs::path at = fs::weakly_canonical(fs::absolute(output));
  for (std::size_t k = 0; k < scans.size(); ++k)
    json["scans"][k]["path"] = fs::canonical(task.files[k]).lexically_relative(at).generic_string();
  save_json(folder / "registration.json", json);
}

}  // namespace

std::vector<fs::path> scans_in_folder(const fs::path& folder) {
  std::vector<fs::path> scans;
  for (const fs::path& file : list_files(folder, "*")) {
    if (is_scan_name(file)) scans.push_back(file);
  }
  if (scans.empty()) throw IoError(folder.string(), "holds no scan (.ply, .pcd, .obj)");
  return scans;
}

std::vector<std::string> scan_names(const std::vector<fs::path>& files) {
  std::set<std::string> plain;
  for (const fs::path& file : files) plain.insert(file.filename().string());
  std::vector<std::string> names;
  for (const fs::path& file : files) {
    const fs::path full = fs::absolute(file).lexically_normal();
    names.push_back(plain.size() == files.size() ? file.filename().string()
                                                 : (full.parent_path().filename() / full.filename()).generic_string());
  }
  return names;
}

JobPlan plan_registration(RegistrationTask task, const fs::path& output) {
  check_ranges(task.options);
  const auto shared = std::make_shared<const RegistrationTask>(std::move(task));
  const std::vector<std::string> names = scan_names(shared->files);
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(k), names[k]) !=
        names.begin() + static_cast<std::ptrdiff_t>(k)) {
      throw InvalidInput(names[k] + ": two scans have this name; give them folders or names of their own");
    }
  }
  const JobInputs inputs = inputs_of(*shared, names);
  JobPlan plan = inputs.plan(output, "registration.json");
  plan.parallel_items = false;
  plan.join = [shared, names, output, key = plan.key](const fs::path& folder, const RunControl& control) {
    const std::vector<PointCloud> scans = read_scans(*shared);
    const JointRegistration result =
        register_jointly(scans, shared->initial, shared->reference, shared->options, control);
    if (!shared->accept_failed) check_all_placed(result, names);
    write_files(folder, *shared, names, scans, result, output, key);
  };
  return plan;
}

}  // namespace patinate::capture
