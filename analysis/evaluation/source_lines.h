/// \file
/// Lines of a source, and of the charts of a map of it: what the figures of lines (M11) are made of.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/cracks/line_mask.h"
#include "analysis/cracks/line_structure.h"
#include "analysis/evaluation/synthesized_map.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

inline constexpr std::size_t kNumLineThresholds = 3;
using LineStructures = std::array<LineStructure, kNumLineThresholds>;  ///< One a threshold.

/// Lengths and areas in texels, where a pixel of the source has one or more.
struct LineScale {
  int reach = 0, least_area = 0;
  double least_run = 0.0;  ///< Pixels of line for a dead end.
  LineStructureOptions structure;

  explicit LineScale(double pixels_per_texel);
};

/// Picture that lines are found in.
struct Ground {
  ImageF lightness;  ///< L*.
  ImageU8 mask;      ///< 0 = outside.
  ImageU8 quarter;   ///< May be empty.
  int x = 0, y = 0;  ///< Its corner in the part.
};

/// L* of sRGB codes.
[[nodiscard]] ImageF lightness_of(const ImageF& codes);

/// Upper ends of the first three quarters of a control's values.
[[nodiscard]] std::array<float, 3> quarters_of(const ImageF& control, const ImageU8& mask);
/// Number of the quarter, 0 to 3.
[[nodiscard]] ImageU8 in_quarters(const ImageF& control, const std::array<float, 3>& ends);

/// The charts of a part, each in its own picture. @param lightness,quarter  Of its rectangle; `quarter` may be empty.
[[nodiscard]] std::vector<Ground> charts_of(const MapPart& part, const ImageF& lightness, const ImageU8& quarter);

/// Lines of one kind in a source.
struct SourceLines {
  LineKind kind = LineKind::Dark;
  std::array<double, kNumLineThresholds> thresholds = {};
  std::array<ImageU8, kNumLineThresholds> masks;
  LineStructures structures;
};
/// Nothing where the source has none (SourceStructure).
[[nodiscard]] std::optional<SourceLines> lines_of(const Ground& source, LineKind kind, const LineScale& scale,
                                                  const RunControl& control);

[[nodiscard]] LineStructures measured(const std::vector<Ground>& charts, const SourceLines& lines,
                                      const LineScale& scale, const RunControl& control);
/// Lines found in charts that show the source as it is.
struct CutSource {
  LineStructures structures;
  /// By threshold: pixels of the source's lines that lie in charts, and those that are found there. Along the border of
  /// a chart half of what surrounds a line is missing, so that narrow charts show fewer than they have.
  std::array<std::int64_t, kNumLineThresholds> there = {}, found = {};
};
/// The charts cut out of the source: each from one of its corners, few charts from all four. Of larger charts, what
/// fits. @param first  Number of the first of the charts. @param num_charts  Of all parts.
[[nodiscard]] CutSource measured_crops(const std::vector<Ground>& charts, std::int64_t first, std::int64_t num_charts,
                                       const Ground& source, const SourceLines& lines, const LineScale& scale,
                                       const RunControl& control);
/// Center lines at the middle threshold, and what ends without meeting another. @param rect  The part's.
[[nodiscard]] Picture line_picture(const std::vector<Ground>& charts, const SourceLines& lines, const TexelRect& rect,
                                   const LineScale& scale, const RunControl& control);

}  // namespace patinate::analysis
