#include "capture/registration/registration_job.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "capture/registration/registration_io.h"
#include "capture/registration/surfels.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/median.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/output/contact_strip.h"
#include "patinate/core/error.h"
#include "patinate/geometry/point_cloud.h"
#include "patinate/geometry/rigid_transform.h"
#include "patinate/image/image.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

struct RegistrationPictureOptions {
  int panel_px = 520;      ///< Width and height of each of the four panels; [64, 4096].
  double turn_deg = 25.0;  ///< Turn of the view about the upright axis (y), from the first scan's line of sight.
  double tilt_deg = 15.0;  ///< From above.
};

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kMargin = 0.05;  ///< Share of the picture left free.
constexpr double kSlice = 0.012;  ///< Thickness of the slice, of the object's size.
constexpr float kBackground = 0.92f;
/// Linear; told apart by people who see colors differently as well [Okabe and Ito 2008].
constexpr std::array<std::array<float, 3>, 8> kColors{{{0.79f, 0.09f, 0.01f},
                                                       {0.01f, 0.17f, 0.45f},
                                                       {0.0f, 0.34f, 0.17f},
                                                       {0.80f, 0.35f, 0.0f},
                                                       {0.60f, 0.19f, 0.39f},
                                                       {0.09f, 0.45f, 0.81f},
                                                       {0.62f, 0.55f, 0.05f},
                                                       {0.12f, 0.12f, 0.12f}}};

struct Dot {
  Vec3 at;  ///< Right, up, towards the viewer.
  int scan;
};

std::vector<Dot> placed(std::span<const PointCloud> scans, std::span<const RigidTransform> poses,
                        const Eigen::Matrix3d& view) {
  std::vector<Dot> dots;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    for (const Vec3& p : scans[k].points) dots.push_back({view * poses[k].apply(p), static_cast<int>(k)});
  }
  return dots;
}

Box box_of(const std::vector<Dot>& dots) {
  Box box;
  for (const Dot& d : dots) {
    box.low = box.low.cwiseMin(d.at);
    box.high = box.high.cwiseMax(d.at);
  }
  return box;
}

/// Dots as discs, the nearest on top; darker where the surface they make falls away from the viewer.
ImageF splat(const std::vector<Dot>& dots, int size, double radius_px, bool is_shaded) {
  const Box box = box_of(dots);
  const double extent = std::max({box.high.x() - box.low.x(), box.high.y() - box.low.y(), 1e-300});
  const double scale = (1.0 - 2.0 * kMargin) * size / extent;
  const double nothing = -std::numeric_limits<double>::infinity();
  Image<double> depth(size, size, 1, nothing);
  Image<int> owner(size, size, 1, -1);
  const int reach = static_cast<int>(std::ceil(radius_px));
  for (const Dot& d : dots) {
    const double x = 0.5 * size + (d.at.x() - box.center().x()) * scale,
                 y = 0.5 * size - (d.at.y() - box.center().y()) * scale;
    const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        if (!depth.contains(cx + dx, cy + dy) || dx * dx + dy * dy > radius_px * radius_px) continue;
        if (d.at.z() * scale <= depth.at(cx + dx, cy + dy)) continue;
        depth.at(cx + dx, cy + dy) = d.at.z() * scale;
        owner.at(cx + dx, cy + dy) = d.scan;
      }
    }
  }
  ImageF picture(size, size, 3, kBackground);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (owner.at(x, y) < 0) continue;
      double light = 1.0;
      if (is_shaded) {
        const auto slope = [&](int dx, int dy) {
          double sum = 0.0;
          for (int k = 1; k <= 3; ++k) {
            if (!depth.contains(x + k * dx, y + k * dy) || !depth.contains(x - k * dx, y - k * dy)) continue;
            const double a = depth.at(x + k * dx, y + k * dy), b = depth.at(x - k * dx, y - k * dy);
            if (a > nothing && b > nothing) sum += std::clamp((a - b) / (2.0 * k), -3.0, 3.0) / 3.0;
          }
          return sum;
        };
        const Vec3 normal = Vec3(-slope(1, 0), slope(0, 1), 1.0).normalized();
        light = 0.25 + 0.75 * std::max(0.0, normal.dot(Vec3(-0.4, 0.5, 0.77)));
      }
      const auto& color = kColors[static_cast<std::size_t>(owner.at(x, y)) % kColors.size()];
      for (int c = 0; c < 3; ++c)
        picture.at(x, y, c) = static_cast<float>(light * (0.15 + 0.85 * static_cast<double>(color[c])));
    }
  }
  return picture;
}

/// Points within a thin slice through the middle, seen from above.
ImageF slice(std::span<const PointCloud> scans, std::span<const RigidTransform> poses, int size) {
  Eigen::Matrix3d from_above;
  from_above << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  std::vector<Dot> dots = placed(scans, poses, from_above);
  std::vector<double> heights;
  for (const Dot& d : dots) heights.push_back(d.at.z());
  const double middle = median(std::move(heights)), half = 0.5 * kSlice * box_of(dots).diagonal();
  std::erase_if(dots, [&](const Dot& d) { return std::abs(d.at.z() - middle) > half; });
  return splat(dots, size, 1.0, false);
}

/// Left as it was, right as it is; above all points that the viewer sees, shaded by their depth; below those within a
/// thin slice through the middle, seen along y.
/// @param before, after  common from scan, as many as scans. @returns linear, 3 channels. @throws InvalidInput if
/// numbers differ or there is no point
ImageF registration_picture(std::span<const PointCloud> scans, std::span<const RigidTransform> before,
                            std::span<const RigidTransform> after, const RegistrationPictureOptions& options) {
  if (scans.size() != before.size() || scans.size() != after.size())
    throw InvalidInput("registration picture: as many poses as scans are needed");
  if (scans.empty() || scans.front().points.empty()) throw InvalidInput("registration picture: there is no point");
  const Vec3 toward = direction_to_scanner(scans.front(), bounding_box(scans.front()).center()).value_or(Vec3(0, 0, 1));
  const double heading = std::atan2(toward.x(), toward.z());
  const Eigen::Matrix3d view = rotation_of(Vec3(options.tilt_deg * kDegree, 0, 0)) *
                               rotation_of(Vec3(0, -heading - options.turn_deg * kDegree, 0));
  const double dot_px = std::max(1.0, options.panel_px / 260.0);
  const std::array<ImageF, 4> panels{splat(placed(scans, before, view), options.panel_px, dot_px, true),
                                     splat(placed(scans, after, view), options.panel_px, dot_px, true),
                                     slice(scans, before, options.panel_px), slice(scans, after, options.panel_px)};
  const std::array<std::string, 4> labels{"before", "after", "before, cut through", "after, cut through"};
  return contact_strip(panels, labels, {.columns = 2});
}

constexpr std::int64_t kStageVersion = 3;  ///< Raised when the same input gives other poses.

bool is_scan_name(const fs::path& path) {
  const std::string extension = lower_extension(path);
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
    if (s.is_misled) {
      throw CannotComplete(names[k] + ": only " + fixed_percent_text(s.staying) +
                           " of its surface lies where the reference's does, so that nothing tells which part has "
                           "stayed; --accept-failed continues without it, --reference takes a scan that changed less");
    }
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
  write_srgb8(folder / "registration.png", registration_picture(placed, before, after, {}));
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
