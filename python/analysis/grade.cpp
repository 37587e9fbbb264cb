#include <pybind11/stl.h>

#include <algorithm>
#include <utility>

#include "analysis/grading/grade_rules.h"
#include "analysis/grading/graded_surface.h"
#include "patinate/core/error.h"
#include "python/analysis/py_series.h"
#include "python/bindings.h"
#include "python/support/arrays.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

std::vector<analysis::GradeRegion> regions_from(const py::object& given) {
  std::vector<analysis::GradeRegion> regions;
  if (given.is_none()) return regions;
  if (!py::isinstance<py::dict>(given)) wrong_type("grade", "regions", given, "a dict of names and masks");
  for (const auto& [name, mask] : py::cast<py::dict>(given)) {
    const auto text = py::cast<std::string>(name);
    regions.push_back({text, mask_from(py::reinterpret_borrow<py::object>(mask), "regions: " + text)});
  }
  return regions;
}

analysis::ScribeRequest scribe_from(const py::object& given) {
  if (given.is_none()) return {};
  if (py::isinstance<py::str>(given)) {
    if (py::cast<std::string>(given) != "auto") throw InvalidInput("scribe: expected \"auto\" or five numbers in mm");
    return {.is_wanted = true};
  }
  if (!py::isinstance<py::sequence>(given))
    wrong_type("grade", "scribe", given, "\"auto\", five numbers in mm, or a list of such");
  const auto list = py::cast<py::sequence>(given);
  const bool is_one = list.size() > 0 && !py::isinstance<py::sequence>(list[0]);
  const auto scribes = is_one ? std::vector<std::vector<double>>{py::cast<std::vector<double>>(given)}
                              : py::cast<std::vector<std::vector<double>>>(given);
  analysis::ScribeRequest request{.is_wanted = !scribes.empty()};
  for (const std::vector<double>& v : scribes) {
    if (v.size() != 5 || (v[0] == v[2] && v[1] == v[3]))
      throw InvalidInput("scribe: expected (x0, y0, x1, y1, width) in mm with two different ends");
    request.given.push_back({v[0], v[1], v[2], v[3], v[4]});
  }
  return request;
}

/// Times x (value, low, high); NaN where a time has none.
ImageF table_of(const std::vector<std::optional<analysis::GradedFigure>>& series) {
  ImageF table(3, static_cast<int>(series.size()), 1, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t t = 0; t < series.size(); ++t) {
    if (!series[t]) continue;
    const int y = static_cast<int>(t);
    table.at(0, y) = static_cast<float>(series[t]->value);
    table.at(1, y) = static_cast<float>(series[t]->low);
    table.at(2, y) = static_cast<float>(series[t]->high);
  }
  return table;
}

/// By name; what no time has is left out.
py::dict figures_by_name(const analysis::GradedRegion& region) {
  py::dict out;
  for (const std::string_view name : analysis::kGradedFigureNames) {
    const std::vector<std::optional<analysis::GradedFigure>> series = region.series(name);
    const bool has_any = std::any_of(series.begin(), series.end(), [](const auto& f) { return f.has_value(); });
    if (has_any) out[std::string(name).c_str()] = array_of(table_of(series));
  }
  return out;
}

py::dict forecasts_by_name(const analysis::GradedRegion& region) {
  py::dict out;
  for (const analysis::FigureForecast& forecast : region.forecasts)
    out[forecast.figure.c_str()] = array_of(table_of({forecast.values.begin(), forecast.values.end()}));
  return out;
}

py::dict grades_by_scale(const analysis::GradedRegion& region, const analysis::GradeRules& rules) {
  py::dict out;
  for (const analysis::GradeScale& scale : rules.scales) {
    py::list names;
    bool has_any = false;
    for (const std::optional<analysis::GradedFigure>& figure : region.series(scale.figure)) {
      has_any = has_any || figure;
      names.append(figure ? py::object(py::str(scale.grades[analysis::grade_index(scale, figure->value)].name))
                          : py::object(py::none()));
    }
    if (has_any) out[scale.name.c_str()] = names;
  }
  return out;
}

}  // namespace

void bind_grade(py::module_& module) {
  define(
      module,
      FunctionText("grade", "Grades of standards for coatings by region and time: rust, cracks, creep, color, gloss.")
          .takes("surface", "History | AgedMesh | str | os.PathLike[str]", "Or the path of a history or transfer")
          .keyword("regions", "dict[str, npt.ArrayLike] | None", "None",
                   "Masks of the surface's size by name; None: the whole sample without its edge")
          .keyword(
              "scribe",
              "Literal[\"auto\"] | tuple[float, float, float, float, float] | "
              "list[tuple[float, float, float, float, float]] | None",
              "None",
              "x0, y0, x1, y1 and width of the scratch or of each, mm; \"auto\": found in the unexposed photograph")
          .keyword("labels", "npt.ArrayLike | None", "None",
                   "H x W, not 0 where rust is marked on the last photograph; its color then counts as rust")
          .keyword("rules", "str | os.PathLike[str] | None", "None", "A file in place of the built-in scales")
          .options<analysis::GradeOptions>()
          .runs()
          .returns("Report",
                   "By region: times (N), figures (by name N x 3: value, low, high), grades (by scale a name a "
                   "time), distribution (of rust, a letter a time), spots (N); with `forecast` forecast_times (M) and "
                   "forecasts (by name M x 3)")
          .raises("InvalidInput if regions lie over each other or hold nothing; IoError"),
      [](const py::object& surface, const py::kwargs& kwargs) {
        Keywords keywords("grade", kwargs);
        analysis::GradeOptions options;
        const std::vector<analysis::GradeRegion> regions = regions_from(keywords.object("regions"));
        const analysis::ScribeRequest scribe = scribe_from(keywords.object("scribe"));
        const py::object labels = keywords.object("labels"), file = keywords.object("rules");
        keywords.read(options);
        const RunArguments run = keywords.run();
        keywords.finish();
        const analysis::GradeRules rules =
            file.is_none() ? analysis::standard_grade_rules() : analysis::read_grade_rules(path_from(file));
        const analysis::TextureSeries series = series_from("grade", "surface", surface);
        const analysis::GradeRequest request{.regions = regions,
                                             .scribe = scribe,
                                             .rust = rules.rust,
                                             .labels = labels.is_none() ? ImageU8() : mask_from(labels, "labels"),
                                             .options = options};
        const analysis::GradedSurface graded = result_of(
            run, [=](const RunControl& control) { return analysis::grade_surface(series, request, control); });
        py::dict out;
        for (const analysis::GradedRegion& region : graded.regions) {
          py::dict dict;
          py::list letters;
          std::vector<int> spots;
          for (const analysis::RegionFigures& time : region.times) {
            letters.append(time.distribution);
            spots.push_back(time.num_spots);
          }
          dict["times"] = array_of(graded.times);
          dict["figures"] = figures_by_name(region);
          dict["grades"] = grades_by_scale(region, rules);
          dict["distribution"] = letters;
          dict["spots"] = spots;
          if (options.forecast) {
            dict["forecast_times"] = array_of(graded.forecast_times);
            dict["forecasts"] = forecasts_by_name(region);
          }
          out[region.name.c_str()] = dict;
        }
        return out;
      });
}

}  // namespace patinate::python
