/// \file
/// Grades of a history as a job: `report.html`, `report.json`, `grades.csv`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/grading/grade_limits.h"
#include "analysis/grading/graded_surface.h"
#include "libcommon/job/job.h"

namespace patinate::analysis {

inline constexpr const char* kGradeReportFile = "report.json";
inline constexpr const char* kGradeTableFile = "grades.csv";
inline constexpr const char* kGradePageFile = "report.html";

struct GradeTask {
  std::filesystem::path history;                                           ///< Or a transfer.
  std::vector<std::pair<std::string, std::vector<double>>> polygons = {};  ///< Name, x and y of corners in mm.
  std::vector<std::pair<std::string, std::filesystem::path>> masks = {};   ///< Name, image: 0 = outside.
  ScribeRequest scribe = {};
  std::filesystem::path labels = {};  ///< Image: not 0 where the last photograph shows rust; "" = none.
  std::filesystem::path rules = {};   ///< "" = standard_grade_rules().
  std::filesystem::path limits = {};  ///< "" = none.
  GradeOptions options = {};
  std::string command = {};  ///< Command that repeats it, for the report; no part of the key.
};

/// Opens all inputs at once. @throws InvalidInput, IoError.
[[nodiscard]] JobPlan plan_grade(GradeTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
