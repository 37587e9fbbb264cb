/// \file
/// Grades as a document for programs, and what page and document both say.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/grading/grade_report.h"

namespace patinate::analysis {

/// A grade with those of the interval's ends.
struct GivenGrade {
  std::string scale, grade, low, high;
};
/// @param least  The least value that can be seen. Nothing where the figure is not known.
[[nodiscard]] std::optional<GivenGrade> grade_of(const GradeScale& scale, const RegionFigures& figures, double least);
/// The least value of the scale's figure that can be seen in a region.
[[nodiscard]] double least_of(const GradeScale& scale, const GradedRegion& region);

/// Writes kGradeReportFile. @param summary  A sentence a region.
void save_grade_document(const std::filesystem::path& folder, const GradeReport& report,
                         const std::vector<std::string>& summary);

}  // namespace patinate::analysis
