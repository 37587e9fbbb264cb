/// \file
/// What a comparison says, as data: figures, curves, pictures. Reports are made of it and know nothing else.
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
  std::optional<double> after = {}, before = {};  ///< Of a moment: the frames between which it lies.
  std::optional<double> split =
      {};                      ///< The same figure for A against itself split in two: what equal surfaces would show.
  std::string undefined = {};  ///< Why there is no value; "" when there is one.
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

/// As reports and files state it: nine significant digits, and a reason exactly where there is no value. To state it
/// again changes nothing, so that a page is the same whether its parts went through a file or not.
/// @throws InvalidInput if a number is not finite.
[[nodiscard]] Figure as_stated(Figure figure);
/// The same of its columns; x stays as it is.
[[nodiscard]] Curve as_stated(Curve curve);

/// As stated, with pictures' sources but not their pixels. @throws InvalidInput if a number is not finite.
[[nodiscard]] Json section_json(const Section& section);
/// The inverse of section_json(); for files of our own only.
[[nodiscard]] Section section_from_json(const Json& json);
/// As stated. Members name, title, unit, value (null when undefined), low, high, after, before, split, undefined: those
/// that there are.
[[nodiscard]] Json figure_json(const Figure& figure);
/// What their JSON is made of.
void describe(DocumentVisitor& v, Figure& figure);
/// Without pixels.
void describe(DocumentVisitor& v, Picture& picture);
/// A header and a row for each figure: section, figure, unit, value, low, high, split, undefined, after, before; what
/// is not there is an empty cell.
[[nodiscard]] std::string figures_csv(std::span<const Section> sections);
/// A header and a row for each x; a value that is not there is an empty cell.
[[nodiscard]] std::string curve_csv(const Curve& curve);

}  // namespace patinate::analysis
