/// \file
/// The figures of a surface's regions at the times of its photographs.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "analysis/grading/grade_rules.h"
#include "analysis/grading/graded_figure.h"
#include "analysis/grading/growth_forecast.h"
#include "patinate/analysis/texture_series.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

struct GradeOptions {
  double edge_mm = 10.0;            ///< Left out along the edge of the whole sample; needs a pixel size.
  std::optional<double> unexposed;  ///< Time of the unexposed surface; not given: the first photograph.
  int crack_reach_px = 5;           ///< Half the width of the widest crack.
  std::optional<double> forecast;   ///< Time to which figures are forecast; not given: none are.
};
void describe(OptionVisitor& v, GradeOptions& o);

/// A straight scratch through the coating, mm from the upper left corner of the picture.
struct Scribe {
  double x0 = 0.0, y0 = 0.0, x1 = 0.0, y1 = 0.0;
  double width_mm = 0.0;
};

/// Whether creep is measured, and from which scratches.
struct ScribeRequest {
  bool is_wanted = false;
  std::vector<Scribe> given = {};  ///< Empty: those that find_scribes() finds in the unexposed photograph.
};

/// A part of the picture.
struct GradeRegion {
  std::string name;
  ImageU8 mask;  ///< H x W, 0 = outside.
};

struct RegionFigures {
  std::array<std::optional<GradedFigure>, kGradedFigureNames.size()> figures = {};
  std::string distribution =
      {};  ///< Distribution of rust [ASTM D610]: S, G, P, H; "" without rust or without a pixel size.
  int num_spots = 0;
  std::optional<double> mean_spot_mm = {};  ///< Diameter of a circle of the same area.

  [[nodiscard]] const std::optional<GradedFigure>& figure(std::string_view name) const;
};

struct FigureForecast {
  std::string figure;
  GrowthTest test = {};
  std::vector<GradedFigure> values = {};  ///< At GradedSurface::forecast_times.
};

struct GradedRegion {
  std::string name;
  std::int64_t num_pixels = 0;
  std::optional<double> area_mm2 = {};
  double seen_from_percent = 0.0;  ///< A single spot of the least size has this share.
  std::vector<RegionFigures> times = {};
  std::vector<FigureForecast> forecasts = {};

  /// A figure by time.
  [[nodiscard]] std::vector<std::optional<GradedFigure>> series(std::string_view figure) const;
};

/// Pictures that a page shows of a time.
struct ShownTime {
  std::size_t time = 0;                        ///< Index.
  ImageF color;                                ///< Linear.
  ImageF rust;                                 ///< Coverage.
  ImageU8 cracks;                              ///< 0 / 255; empty where they are not looked for.
  std::array<std::vector<int>, 2> marks = {};  ///< Blisters and flakes by pixel, -1 = none; empty without heights.
};

struct GradedSurface {
  std::vector<double> times = {};
  std::vector<double> forecast_times = {};  ///< Behind the last photograph.
  std::optional<double> pixel_mm = {};
  std::optional<double> unexposed_time = {};
  double edge_mm = 0.0;  ///< That was left out.
  std::vector<Scribe> scribes = {};
  std::vector<GradedRegion> regions = {};
  std::vector<ShownTime> shown = {};  ///< At most four, the last among them.
  std::vector<std::string> notes = {};
};

/// What is graded, and what counts.
struct GradeRequest {
  std::vector<GradeRegion> regions = {};  ///< Empty: the whole sample less its edge.
  ScribeRequest scribe = {};
  RustRule rust = {};
  ImageU8 labels = {};  ///< H x W, not 0 where the last photograph shows rust; empty: `rust` says what it is.
  GradeOptions options = {};
};
/// @throws InvalidInput if regions lie over each other, have equal names or another size, or hold nothing of the
/// sample, if the edge leaves nothing, the labels have another size or mark too little, a scribe ends outside of the
/// sample or none is found, if `forecast` is not after the last photograph, or `unexposed` is no time of a photograph.
[[nodiscard]] GradedSurface grade_surface(const TextureSeries& series, GradeRequest request,
                                          const RunControl& control = {});

}  // namespace patinate::analysis
