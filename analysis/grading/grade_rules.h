/// \file
/// Scales of standards: which value gets which grade. One data file holds them with standard, edition and clause, so
/// that a laboratory can check and replace every number.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/core/json.h"

namespace patinate::analysis {

/// A value up to `up_to`, and above that of the grade before, has this grade.
struct Grade {
  std::string name;  ///< A whole number: standards differ in whether 0 is the best.
  double up_to = 0.0;
  std::string word = {};  ///< What the standard calls it besides, "few"; mostly none.
};

struct GradeScale {
  std::string name;    ///< "ri"
  std::string title;   ///< "Degree of rusting Ri"
  std::string figure;  ///< One of kGradedFigureNames.
  std::string standard, edition, clause;
  bool is_checked = false;  ///< Somebody compared the limits with the standard's text.
  std::string note;
  std::vector<Grade> grades;  ///< From the unexposed surface on; limits rise.
};

/// Rule for rust.
struct RustRule {
  double low_hue_deg = 20, high_hue_deg = 85;  ///< CIELAB, D65; around the circle, so that 350 to 370 is 350 to 10.
  double least_chroma = 14;
  double least_lightness = 0, most_lightness = 62;
  double least_change = 12;    ///< CIE 1976 difference from the unexposed surface.
  double least_area_px = 1.5;  ///< Smaller spots are not told from noise.
  double pinpoint_mm = 1.5;    ///< Spots of a smaller diameter are pinpoints of ASTM D610.
};

struct GradeRules {
  RustRule rust;
  std::vector<GradeScale> scales;
};

/// Index into `scale.grades`. @param value  >= 0; above all limits: the last.
[[nodiscard]] std::size_t grade_index(const GradeScale& scale, double value);

/// Those of grades.json.
[[nodiscard]] GradeRules standard_grade_rules();
/// @throws IoError: unknown members or figures, limits that do not rise, grades that are no whole numbers, two scales
/// of one name.
[[nodiscard]] GradeRules read_grade_rules(const std::filesystem::path& file);

}  // namespace patinate::analysis
