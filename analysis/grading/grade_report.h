/// \file
/// Grades as a page for people, a table, and a document for programs.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/grading/grade_job.h"
#include "analysis/grading/grade_times.h"
#include "patinate/analysis/texture_series.h"

namespace patinate::analysis {

/// Content of a report.
struct GradeReport {
  const SeriesFile& series;
  const GradeTask& task;
  const GradeRules& rules;
  GradedSurface surface;
  std::vector<LimitResult> limits;
  std::string key;
};

/// Writes kGradePageFile, kGradeTableFile and kGradeReportFile, this one last.
void write_grade_report(const std::filesystem::path& folder, const GradeReport& report);
/// "Rusted area, %". @param figure  One of kGradedFigureNames.
[[nodiscard]] std::string figure_title(std::string_view figure);
/// One line a region, for the end of a command: "sample: rusted 0.42 % (0.38 to 0.47), Ri 2, D610 6-G".
[[nodiscard]] std::vector<std::string> grade_lines(const GradeReport& report);

}  // namespace patinate::analysis
