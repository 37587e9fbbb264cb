/// \file
/// Figures that laboratories report, of one region at one time.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace patinate::analysis {

/// Names as reports, tables and limits have them.
inline constexpr std::array<std::string_view, 17> kGradedFigureNames{
    "rusted_percent", "blistered_percent", "blister_mm",   "flaked_percent", "flake_mm",  "crack_mm_per_mm2",
    "crack_width_mm", "creep_mm",          "creep_max_mm", "delta_e",        "ciede2000", "delta_l",
    "delta_a",        "delta_b",           "gloss_20",     "gloss_60",       "gloss_85"};

/// Where the edge of a blurred mark lies; chosen on drawn panels of rust (docs/algorithms/grading.md).
inline constexpr double kEdgeUncertainty_px = 0.25;

/// A measured value and the ends of its interval, which holds the truth in about 90 of 100 cases.
struct GradedFigure {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;

  friend bool operator==(const GradedFigure&, const GradedFigure&) = default;
};

}  // namespace patinate::analysis
