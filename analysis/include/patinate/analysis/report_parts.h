/// The results of a comparison as data: figures, curves, pictures. Reports are made from these alone.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/image/image.h"

namespace patinate {
class DocumentVisitor;
}  // namespace patinate

namespace patinate::analysis {

/// One number. Undefined ones say why; none is ever NaN.
struct Figure {
  std::string name = {};   ///< snake_case, unique in a report.
  std::string title = {};  ///< For people.
  std::string unit = {};
  std::optional<double> value = {};
  std::optional<double> low = {}, high = {};      ///< 95 % interval.
  std::optional<double> after = {}, before = {};  ///< For a figure that is a time: the frames before and after it.
  std::optional<double> split = {};  ///< The same figure for the two halves of A: its value for equal surfaces.
  std::string undefined = {};        ///< Why there is no value; "" when there is one.
};

struct CurveColumn {
  std::string name = {};                             ///< For the CSV and the legend.
  std::vector<std::optional<double>> values = {};    ///< As many as the curve's x.
  std::vector<std::pair<double, double>> band = {};  ///< 95 % interval; none or as many.
  bool is_reference = false;                         ///< Drawn dashed: serves comparison only.
};
/// Several columns over one axis: a CSV and a chart.
struct Curve {
  std::string name = {};  ///< File name without extension.
  std::string title = {};
  std::string x_name = {};
  std::string y_name = {};
  std::vector<double> x = {};
  std::vector<CurveColumn> columns = {};
  bool is_logarithmic = false;  ///< Both axes.
  bool from_zero = true;
};

struct Picture {
  std::string name = {};  ///< File name without extension.
  std::string caption = {};
  ImageF image = {};        ///< Linear, 3 channels; may be empty where there is a source.
  std::string source = {};  ///< What a page shows: a data: URI, or a file relative to the page; "" = not made yet.
};

struct Section {
  std::string name = {};
  std::string title = {};
  std::vector<std::string> paragraphs = {};
  std::vector<Figure> figures = {};
  std::vector<Curve> curves = {};
  std::vector<Picture> pictures = {};
  std::string undefined = {};  ///< Why the section says nothing; "" when it does.
};

/// Rounds a figure as reports and files print it: nine significant digits, and a reason exactly if there is no value.
/// Rounding again changes nothing, so a page is the same whether its parts went through a file or not.
[[nodiscard]] Figure as_stated(Figure figure);
/// Rounds the columns of a curve in the same way; x is unchanged.
[[nodiscard]] Curve as_stated(Curve curve);

/// JSON of a section, rounded by as_stated(); pictures have their sources but not their pixels.
[[nodiscard]] Json section_json(const Section& section);
/// The inverse of section_json(); for files of our own only.
[[nodiscard]] Section section_from_json(const Json& json);
/// JSON of a figure, rounded by as_stated(). Existing members only: name, title, unit, value (null when undefined),
/// low, high, after, before, split, undefined.
[[nodiscard]] Json figure_json(const Figure& figure);
/// Describes the members of a figure's JSON.
void describe(DocumentVisitor& v, Figure& figure);
/// Without pixels.
void describe(DocumentVisitor& v, Picture& picture);
/// A header and a row for each figure: section, figure, unit, value, low, high, split, undefined, after, before; what
/// is not there is an empty cell.
[[nodiscard]] std::string figures_csv(std::span<const Section> sections);
/// A header and a row for each x; a value that is not there is an empty cell.
[[nodiscard]] std::string curve_csv(const Curve& curve);

}  // namespace patinate::analysis
