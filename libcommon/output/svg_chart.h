/// \file
/// Line charts as SVG text: for pages that carry everything inside.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace patinate {

/// A curve; points without value are gaps.
struct ChartSeries {
  std::string name = {};  ///< For the legend.
  std::vector<double> x = {};
  std::vector<std::optional<double>> y = {};         ///< Value at each x.
  std::vector<std::pair<double, double>> band = {};  ///< Low and high at each x, drawn pale; none or as many as x.
  bool is_dashed = false;                            ///< For what only serves comparison.
};

struct Chart {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  bool from_zero = true;  ///< The y axis includes 0.
  bool log_x = false;     ///< Values must then be > 0.
  bool log_y = false;
  /// Range of the y axis, where that is not all: curves leave the picture there. Low below high; of a log_y both > 0.
  std::optional<std::pair<double, double>> y_range = {};
  std::vector<ChartSeries> series =
      {};  ///< Colors of [Okabe and Ito 2008], told apart by any color vision, and a dash pattern each.
};

/// An `<svg>` element without outer references: its ink follows the page (`currentColor`). Equal charts give equal
/// text.
/// @throws InvalidInput if a series' lists differ in length or a number is not finite. A chart without any value says
/// so.
[[nodiscard]] std::string svg_chart(const Chart& chart);

/// A file of its own. @param chart  As svg_chart() gives it.
[[nodiscard]] std::string svg_document(std::string chart);

}  // namespace patinate
