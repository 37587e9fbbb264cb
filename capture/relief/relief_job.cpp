#include "capture/relief/relief_job.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/project/given_registration.h"
#include "capture/relief/relief_report.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/job/job_inputs.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/mesh_files/point_cloud_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 1;  ///< Raised when the same input gives other output.
constexpr float kMidGray = 0.5f;

std::vector<PointCloud> read_scans(const ReliefTask& task) {
  std::vector<PointCloud> scans;
  for (const PlacedScanFile& scan : task.scans) {
    scans.push_back(read_point_cloud(scan.path));
    scale_cloud(scans.back(), task.mm_per_unit);
  }
  return scans;
}

ImageU8 read_stable(const fs::path& file, const ReliefView& view) {
  if (file.empty()) return {};
  ImageU8 stable = read_mask(file);
  if (stable.width() != view.width || stable.height() != view.height)
    throw IoError(file.string(), "is " + size_text(stable.width(), stable.height()) +
                                     " pixels; expected those of the maps, " + size_text(view.width, view.height) +
                                     ": paint on a picture that a run without it has made");
  return stable;
}

void write_frames(HistoryWriter& writer, const fs::path& folder, const ReliefTask& task, const Relief& relief) {
  const ReliefView& view = relief.view;
  const ImageF gray(view.width, view.height, 3, kMidGray);
  std::size_t change = 0;
  for (std::size_t k = 0; k < task.scans.size(); ++k) {
    const int index = static_cast<int>(k);
    const bool is_reference = k == task.reference;
    writer.write_frame(index, task.times[k], gray);
    HistoryWriter::write_frame_extra(folder, index, "height",
                                     is_reference ? ImageF(view.width, view.height) : relief.changes[change].change_mm);
    writer.add_written_frame_extra(index, "height");
    if (is_reference) continue;
    const fs::path mask = folder / HistoryWriter::frame_mask_file(index);
    fs::create_directories(mask.parent_path());
    write_codes(mask, relief.changes[change].measured);
    writer.add_written_frame_mask(index);
    ++change;
  }
}

void write_all(const fs::path& folder, const ReliefTask& task, const Relief& relief, const std::string& key) {
  HistoryManifest manifest;
  manifest.name = task.name;
  manifest.width = relief.view.width, manifest.height = relief.view.height;
  manifest.texel_size_mm = relief.view.texel;
  manifest.time_unit = task.time_unit;
  manifest.key = key;
  HistoryWriter writer(folder, manifest);
  writer.write_mask(relief.surface);
  HistoryWriter::write_map(folder, "position", relief.position_mm);
  HistoryWriter::write_map(folder, "normal", relief.normal);
  writer.add_written_map("position");
  writer.add_written_map("normal");
  write_frames(writer, folder, task, relief);
  std::vector<HistoryWarning> warnings;
  std::size_t change = 0;
  for (std::size_t k = 0; k < task.scans.size(); ++k) {
    if (k == task.reference) continue;
    for (HistoryWarning& w : relief_warnings(relief.changes[change], task.scans[k].name, !task.stable.empty()))
      warnings.push_back(std::move(w));
    ++change;
  }
  if (!relief.view.is_side_known)
    warnings.push_back({.about = WarningSubject::Series,
                        .text = "the scans do not say which side of the surface is outside; +z was taken",
                        .cure = "give the viewer's direction as --toward X,Y,Z"});
  sort_warnings(warnings);
  for (const HistoryWarning& w : warnings) writer.add_warning(w);
  write_relief_report(folder, task, relief, warnings, key);
  writer.finish();
}

}  // namespace

ReliefTask relief_task_of(const fs::path& path, std::optional<double> mm_per_unit) {
  const fs::path file = fs::is_directory(path) ? path / "registration.json" : path;
  ReliefTask task;
  const GivenScans given = read_given_scans(file, mm_per_unit);
  task.mm_per_unit = given.mm_per_unit;
  for (const GivenScan& scan : given.scans) {
    if (!scan.reference_from_scan) continue;
    if (scan.path.empty() || !fs::exists(scan.path))
      throw IoError(file.string(),
                    "does not say where " + scan.name + " is, or it is there no more: " + scan.path.string());
    if (scan.name == given.reference) task.reference = task.scans.size();
    task.scans.push_back({scan.name, scan.path, *scan.reference_from_scan});
  }
  if (task.scans.size() < 2) throw IoError(file.string(), "has a place for fewer than 2 scans");
  return task;
}

void set_times(std::vector<double> times, ReliefTask& task) {
  const std::size_t n = task.scans.size();
  if (times.empty()) {
    times.resize(n);
    std::iota(times.begin(), times.end(), 0.0);
  }
  if (times.size() != n)
    throw InvalidInput("times: found " + std::to_string(times.size()) + " times; the registration has placed " +
                       std::to_string(n) + " scans");
  for (std::size_t k = 1; k < n; ++k) {
    if (!(times[k] > times[k - 1]))
      throw InvalidInput("times: " + number_text(times[k]) + " follows " + number_text(times[k - 1]) +
                         "; scans are registered in the order of time, which increases");
  }
  task.times = std::move(times);
}

JobPlan plan_relief(ReliefTask task, const fs::path& output) {
  check_ranges(task.options);
  JobInputs inputs("relief", kStageVersion);
  inputs.add_value("name", task.name);
  for (std::size_t k = 0; k < task.scans.size(); ++k) {
    const PlacedScanFile& scan = task.scans[k];
    inputs.add_file("scan", scan.path);
    std::string pose = number_text(task.times[k]) + " " + scan.name;
    for (const double v : scan.reference_from_scan.matrix().reshaped()) pose += " " + number_text(v);
    inputs.add_value("time and pose of " + scan.name, pose);
  }
  inputs.add_value("reference", task.scans[task.reference].name);
  inputs.add_value("--unit", number_text(task.mm_per_unit));
  inputs.add_value("--time-unit", time_unit_text(task.time_unit));
  if (!task.stable.empty()) inputs.add_file("--stable", task.stable);
  inputs.add_options(option_values(task.options));
  JobPlan plan = inputs.plan(output, kHistoryManifestFile);
  plan.parallel_items = false;
  const auto shared = std::make_shared<const ReliefTask>(std::move(task));
  plan.join = [shared, key = plan.key](const fs::path& folder, const RunControl& control) {
    const std::vector<PointCloud> scans = read_scans(*shared);
    std::vector<RigidTransform> poses;
    for (const PlacedScanFile& scan : shared->scans) poses.push_back(scan.reference_from_scan);
    const Relief relief = measure_relief(
        scans, poses, shared->reference, [&](const ReliefView& view) { return read_stable(shared->stable, view); },
        shared->options, control);
    write_all(folder, *shared, relief, key);
  };
  return plan;
}

}  // namespace patinate::capture
