#include <nlohmann/json.hpp>
#include <utility>

#include "app/request/path_kind.h"
#include "patinate/analysis/comparison.h"
#include "patinate/core/error.h"
#include "python/analysis/py_analysis.h"
#include "python/analysis/py_series.h"
#include "python/bindings.h"
#include "python/history/py_history.h"
#include "python/support/arrays.h"
#include "python/support/json.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "python/transfer/py_transfer.h"

namespace patinate::python {

namespace py = pybind11;

py::dict figures_of(const std::vector<analysis::Figure>& figures) {
  py::dict out;
  for (const analysis::Figure& figure : figures) out[figure.name.c_str()] = object_of(figure_json(as_stated(figure)));
  return out;
}

py::list pictures_of(std::vector<analysis::Picture> pictures) {
  py::list out;
  for (analysis::Picture& picture : pictures) {
    py::dict dict;
    dict["name"] = picture.name;
    dict["caption"] = picture.caption;
    if (!picture.image.empty()) dict["image"] = array_of(std::move(picture.image));
    out.append(dict);
  }
  return out;
}

std::optional<analysis::TextureSeries> series_in_memory(const py::object& given) {
  if (py::isinstance<PyHistory>(given)) return analysis::TextureSeries(py::cast<const PyHistory&>(given).value);
  if (!py::isinstance<PyAged>(given)) return std::nullopt;
  const transfer::AgedMesh& aged = *py::cast<const PyAged&>(given).value;
  return analysis::TextureSeries(
      aged.shown, {.name = "atlas", .coordinates = aged.coordinates, .texel_mm = aged.surface.texel_size_mm});
}

analysis::TextureSeries series_from(const std::string& function, const char* name, const py::object& given) {
  if (std::optional<analysis::TextureSeries> series = series_in_memory(given)) return *std::move(series);
  if (py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__")) {
    const std::string path = path_from(given);
    return result_of({}, [=](const RunControl&) { return analysis::open_series(app::history_place(path)).series; });
  }
  wrong_type(function, name, given, "a History, an AgedMesh, or the path of a history or transfer");
}

namespace {

using CompareKeywords = Seeded<analysis::CompareOptions>;

py::dict section_of(analysis::Section section) {
  py::dict out;
  out["title"] = section.title;
  py::list paragraphs;
  for (const std::string& text : section.paragraphs) paragraphs.append(text);
  out["paragraphs"] = paragraphs;
  out["figures"] = figures_of(section.figures);
  py::dict curves;
  for (const analysis::Curve& curve : section.curves) {
    py::dict dict;
    dict["title"] = curve.title;
    dict["x_name"] = curve.x_name;
    dict["y_name"] = curve.y_name;
    dict["x"] = array_of(curve.x);
    py::dict columns;
    for (const analysis::CurveColumn& column : curve.columns) {
      std::vector<double> values;
      for (const std::optional<double>& v : column.values)
        values.push_back(v.value_or(std::numeric_limits<double>::quiet_NaN()));
      columns[column.name.c_str()] = array_of(values);
    }
    dict["columns"] = columns;
    curves[curve.name.c_str()] = dict;
  }
  out["curves"] = curves;
  out["pictures"] = pictures_of(std::move(section.pictures));
  out["undefined"] = section.undefined;
  return out;
}

}  // namespace

void bind_compare(py::module_& module) {
  define(
      module,
      FunctionText("compare",
                   "What is said about two surfaces that age: colors, places, controls, structure, with intervals.")
          .takes("a", "History | AgedMesh | str | os.PathLike[str]",
                 "Or the path of a history, a simulation or a transfer")
          .takes("b", "History | AgedMesh | str | os.PathLike[str]", "What it is compared with")
          .options<CompareKeywords>({.seed = kDefaultSeed})
          .runs()
          .returns("Report",
                   "By section (look, places, colors, controls, structure, cracks): title, paragraphs, figures (by "
                   "name: value, low, "
                   "high, unit, undefined), curves (by name: x and columns, NaN where undefined), pictures, undefined")
          .raises("InvalidInput if the surfaces have no time in common; IoError"),
      [](const py::object& a, const py::object& b, const py::kwargs& kwargs) {
        Keywords keywords("compare", kwargs);
        CompareKeywords options{.seed = kDefaultSeed};
        keywords.read(options);
        const RunArguments run = keywords.run();
        keywords.finish();
        options.options.seed = static_cast<std::uint64_t>(options.seed);
        const analysis::TextureSeries left = series_from("compare", "a", a), right = series_from("compare", "b", b);
        std::vector<analysis::Section> sections = result_of(
            run, [=](const RunControl& control) { return analysis::compare(left, right, options.options, control); });
        py::dict out;
        for (analysis::Section& section : sections) {
          const std::string name = section.name;
          out[name.c_str()] = section_of(std::move(section));
        }
        return out;
      });
}

}  // namespace patinate::python
