/// \file
/// Height change as a job: a registration in, a history whose frames have heights out, with maps, figures and a page.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/relief/relief_change.h"
#include "libcommon/job/job.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

inline constexpr const char* kReliefFile = "relief.json";
inline constexpr const char* kReliefTableFile = "relief.csv";
inline constexpr const char* kReliefPageFile = "report.html";

/// A scan that a registration has placed.
struct PlacedScanFile {
  std::string name;
  std::filesystem::path path;
  RigidTransform reference_from_scan;  ///< mm.
};

struct ReliefTask {
  std::string name;                   ///< Name of the history.
  std::vector<PlacedScanFile> scans;  ///< At least 2, in the order of time.
  std::size_t reference = 0;
  double mm_per_unit = 1.0;   ///< Mm per unit of the scans' files.
  std::vector<double> times;  ///< Time of each scan, increasing.
  TimeUnit time_unit = TimeUnit::Days;
  std::filesystem::path stable;  ///< Image of the view's size, white where the surface is known to stay; "" = none.
  ReliefOptions options;
};

/// The scans of a registration.json that have a place, and which of them is the reference; times are left empty.
/// @param path  The file, or its folder. @param mm_per_unit  Of the scans, where the registration does not say
/// it. @throws IoError
[[nodiscard]] ReliefTask relief_task_of(const std::filesystem::path& path, std::optional<double> mm_per_unit);

/// Sets ReliefTask::times. @param times  As many as scans, increasing; none: their numbers from 0. @throws InvalidInput
void set_times(std::vector<double> times, ReliefTask& task);

/// history.json and its images, change/NNNN.exr and .png a scan, relief.json, relief.csv, report.html.
[[nodiscard]] JobPlan plan_relief(ReliefTask task, const std::filesystem::path& output);

}  // namespace patinate::capture
