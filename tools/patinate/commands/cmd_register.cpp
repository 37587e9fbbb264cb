#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "capture/registration/registration_io.h"
#include "capture/registration/registration_job.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "patinate/mesh_files/point_cloud_io.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

void add_poses(const std::vector<ScanPose>& poses, capture::RegistrationTask& task) {
  for (const ScanPose& pose : poses) {
    app::require_exists(pose.scan);
    task.files.push_back(pose.scan);
    task.initial.emplace_back(pose.world_from_scan);
  }
}

/// Scans, folders of scans, and .conf files, which bring poses.
void add_scans(const std::vector<fs::path>& given, capture::RegistrationTask& task) {
  for (const fs::path& path : given) {
    if (fs::is_directory(path)) {
      for (const fs::path& file : capture::scans_in_folder(path)) task.files.push_back(file);
      task.initial.resize(task.files.size());
    } else if (lower_extension(path) == ".conf") {
      add_poses(read_scan_poses(path), task);
    } else {
      task.files.push_back(path);
      task.initial.emplace_back();
    }
  }
  if (task.files.size() < 2)
    throw app::UsageError("SCANS: found " + std::to_string(task.files.size()) +
                          "; at least 2 scans are needed, or a .conf or folder that holds them");
}

/// Poses of another .conf for the scans that it names, by name, or by folder and name.
void set_initial(const fs::path& conf, const std::vector<std::string>& names, capture::RegistrationTask& task) {
  std::size_t num_found = 0;
  for (const ScanPose& pose : read_scan_poses(conf)) {
    for (std::size_t k = 0; k < names.size(); ++k) {
      const std::string full = pose.scan.generic_string();
      if (full != names[k] && !full.ends_with("/" + names[k])) continue;
      task.initial[k] = pose.world_from_scan;
      ++num_found;
    }
  }
  if (num_found == 0) throw IoError(conf.string(), "names none of the scans; they are named like " + names.front());
}

int reference_index(const std::string& text, const std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  const std::optional<double> number = parse_number(text);
  if (number && *number >= 0.0 && *number < static_cast<double>(names.size()) && *number == static_cast<int>(*number))
    return static_cast<int>(*number);
  throw app::UsageError("--reference: found `" + text + "`; expected a scan's name or its number from 0 to " +
                        std::to_string(names.size() - 1) + did_you_mean(text, names));
}

}  // namespace

int cmd_register(CommandRun& run) {
  std::vector<fs::path> given;
  fs::path output, initial;
  std::string reference = "0";
  capture::RegistrationTask task;
  run.line.positional_list(
      "SCANS", "Scans (.ply, .pcd, .obj), folders of scans, or .conf files that name scans and where they stand",
      given);
  run.line.output("FOLDER", "Folder to make: registration.json, poses.conf, registration.png", output);
  run.line.option("reference", "SCAN",
                  "The scan whose frame the others are brought into: its name, or its number from 0", reference);
  run.line.option("initial", "FILE", "A .conf with approximate poses of the scans", initial);
  run.line.option("unit", "UNIT", "Length unit of the scans; results are in it, and the table in mm", task.unit);
  run.line.choices({"um", "mm", "cm", "m"});
  run.line.options(task.options);
  run.line.flag("merged", "Write merged.ply too: all points in the reference's frame", task.write_merged);
  run.line.flag("moved", "Write scans/NAME.ply too: every scan in the reference's frame", task.write_scans);
  run.line.flag("accept_failed",
                "Continue when a scan cannot be placed for certain: it is excluded, or held where its shape leaves a "
                "degree of freedom unconstrained",
                task.accept_failed);
  run.line.usual({"unit", "reference", "method", "merged", "moved"});
  run.line.example("register day00.ply day07.ply day14.ply --unit mm -o registered");
  run.line.example("register bunny/bun.conf --unit m --merged -o registered");
  if (!run.parse()) return 0;

  add_scans(given, task);
  const std::vector<std::string> names = capture::scan_names(task.files);
  task.reference = reference_index(reference, names);
  if (!initial.empty()) set_initial(initial, names, task);
  if (std::none_of(task.initial.begin(), task.initial.end(), [](const auto& pose) { return pose.has_value(); }))
    task.initial.clear();
  const std::string file = names[task.reference];
  const std::optional<JobStatus> status =
      run.make_folder(capture::plan_registration(std::move(task), output), "register");
  if (!status) return 0;

  Json registration = load_json(output / "registration.json");
  update_spelling(registration, 1, {{"free_motions", "unconstrained_dofs"}});
  for (const std::string& line : capture::registration_table(registration)) run.note(line);
  Json scans = Json::array();
  for (const Json& s : registration.at("scans")) {
    scans.push_back({{"file", s.at("file")},
                     {"status", s.at("status")},
                     {"matrix", s.at("matrix")},
                     {"residual", s.at("residual")},
                     {"overlap", s.at("overlap")}});
  }
  run.report_output(*status, output,
                    Json{{"reference", file},
                         {"unit", registration.at("unit")},
                         {"scans", scans},
                         {"closure", registration.at("closure")}});
  return 0;
}

}  // namespace patinate::cli
