/// \file
/// What an ingest says of a color chart: `chart` of survey.json as drift, notes and warnings.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// How the light of a photograph differs from that of the first one.
struct ChartDrift {
  int number = 0;         ///< Number of the photograph, as `exclude` counts.
  double exposure = 1.0;  ///< Times as much light in its codes.
  double red = 1.0;       ///< Red over green, and blue over green.
  double blue = 1.0;
};

/// Member `chart` of a history's survey.json; null without one. @throws IoError
[[nodiscard]] Json read_chart(const std::filesystem::path& history);
/// @param chart  As read_chart() gives it; null gives nothing, here and below.
[[nodiscard]] std::vector<ChartDrift> chart_drift(const Json& chart);
/// How well the colors fit, and how exposure and white balance drifted; a line each.
[[nodiscard]] std::vector<std::string> chart_notes(const Json& chart);
/// Photographs whose light is interpolated, colors that fit badly, and light that falls off over the chart.
[[nodiscard]] std::vector<HistoryWarning> chart_warnings(const Json& chart);

}  // namespace patinate::capture
