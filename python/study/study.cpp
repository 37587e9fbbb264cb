// Questions that only `patinate study` asks: patinate/_study is its other half. Nothing here is for users of the
// module.
#include <pybind11/stl.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fit/fit_job.h"
#include "analysis/fit/fit_objective.h"
#include "app/fit/fit_scene.h"
#include "app/request/history_library.h"
#include "app/request/path_kind.h"
#include "libcommon/controls/control_expression.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/latin_hypercube.h"
#include "libcommon/core/printable.h"
#include "libcommon/core/temporary_file.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "libcommon/output/html_page.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "patinate/image/image_io.h"
#include "patinate/transfer/control_matching.h"
#include "python/bindings.h"
#include "python/support/json.h"
#include "transfer/synthesis/transfer_controls.h"

namespace patinate::python {

namespace py = pybind11;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxElements = 100'000;
constexpr int kThumbnail_px = 240;

/// A value of a JSON file, with all of the file.
struct FileJson {
  std::shared_ptr<const Json> root;
  JsonReader json;
};

std::string text_of(const FileJson& value) {
  return value.json.is_string() ? value.json.string() : number_text(value.json.number());
}

void bind_json(py::module_& module) {
  module.def("_read_json", [](const std::string& file) {
    auto root = std::make_shared<const Json>(load_json(file));
    return FileJson{root, JsonReader(file, *root)};
  });
  module.def("_load_json", [](const std::string& file) { return object_of(load_json(file)); });
  const auto member = [](FileJson& of, const std::string& key) { return FileJson{of.root, of.json.member(key)}; };
  py::class_<FileJson>(module, "_FileJson")
      .def_property_readonly("file", [](const FileJson& v) { return v.json.file(); })
      .def_property_readonly("pointer", [](const FileJson& v) { return v.json.pointer(); })
      .def("has", [](const FileJson& v, const std::string& key) { return v.json.has(key); })
      .def("is_object", [](const FileJson& v) { return v.json.is_object(); })
      .def("is_array", [](const FileJson& v) { return v.json.is_array(); })
      .def("member", member)
      .def("members",
           [member](FileJson& v) {
             std::vector<std::pair<std::string, FileJson>> members;
             for (const std::string& key : v.json.keys()) members.emplace_back(key, member(v, key));
             return members;
           })
      .def("elements",
           [](const FileJson& v) {
             std::vector<FileJson> elements;
             for (JsonReader& e : v.json.elements(kMaxElements)) elements.push_back({v.root, std::move(e)});
             return elements;
           })
      .def("string", [](const FileJson& v) { return v.json.string(); })
      .def("boolean", [](const FileJson& v) { return v.json.boolean(); })
      .def("number", [](const FileJson& v) { return v.json.number(); })
      .def("positive", [](const FileJson& v) { return v.json.number(above(0)); })
      .def("integer", [](const FileJson& v, double low, double high) { return v.json.integer(between(low, high)); })
      .def("text", &text_of)
      .def("choice",
           [](const FileJson& v, const std::vector<std::string>& names) {
             const std::vector<std::string_view> views(names.begin(), names.end());
             return names[v.json.choice(views)];
           })
      .def("path", [](const FileJson& v) { return v.json.path().string(); })
      .def("expect_format", [](FileJson& v, const std::string& format) { v.json.expect_format(format, 1); })
      .def("fail", [](const FileJson& v, const std::string& expected) { v.json.fail(expected); })
      .def("finish", [](const FileJson& v) { v.json.finish(); });
}

analysis::FitRange range_from(const py::dict& given) {
  const auto text = [&](const char* key) { return given.contains(key) ? py::cast<std::string>(given[key]) : ""; };
  return {.name = text("name"),
          .low = py::cast<double>(given["low"]),
          .high = py::cast<double>(given["high"]),
          .scale = text("scale") == "log" ? analysis::FitScale::Log : analysis::FitScale::Linear,
          .place = text("place")};
}

py::dict dict_of(const analysis::FitRange& range) {
  py::dict dict;
  dict["name"] = range.name;
  dict["low"] = range.low;
  dict["high"] = range.high;
  dict["scale"] = range.scale == analysis::FitScale::Log ? "log" : "linear";
  dict["place"] = range.place;
  dict["is_own"] = range.is_own;
  return dict;
}

app::FitScene scene_with(const std::string& scene, const std::vector<py::dict>& given) {
  std::vector<analysis::FitRange> ranges;
  for (const py::dict& range : given) ranges.push_back(range_from(range));
  return app::FitScene(scene, ranges, {}, {});
}

void bind_numbers(py::module_& module) {
  module.def("_read_fit_range", [](const FileJson& v) { return dict_of(analysis::read_fit_range(v.json)); });
  module.def("_value_at", [](const py::dict& range, bool is_whole, double share) {
    return analysis::value_at({.range = range_from(range), .is_whole = is_whole}, share);
  });
  module.def("_scene_numbers", [](const std::string& scene, const std::vector<py::dict>& ranges) {
    py::list numbers;
    const app::FitScene read = scene_with(scene, ranges);
    for (const analysis::FitParameter& p : read.parameters()) {
      py::dict number;
      number["is_whole"] = p.is_whole;
      number["is_appearance"] = p.is_appearance;
      number["problem"] = analysis::start_problem(p);
      numbers.append(number);
    }
    return numbers;
  });
  module.def("_write_scene",
             [](const std::string& scene, const std::vector<py::dict>& ranges, const std::vector<double>& values,
                const std::string& folder) { scene_with(scene, ranges).write(folder, "scene", folder, values); });
  module.def("_latin_hypercube", &latin_hypercube);
  module.def("_check_fit_term", [](const std::string& name) { (void)analysis::parse_fit_term(name); });
  module.def("_fit_budget_problem", [](int evaluations, int population, std::size_t num_aged, std::size_t num_looks) {
    analysis::FitOptions options;
    if (evaluations > 0) options.evaluations = evaluations;
    options.population = population;
    const analysis::FitBudget budget = analysis::fit_budget(options, num_aged, num_looks);
    return budget.evaluations < budget.least ? analysis::budget_problem(budget) : "";
  });
}

/// A picture that is small enough to be part of a page. @param scratch  A PNG file.
std::string thumbnail(const std::string& file, const std::string& scratch) {
  const ImageF image = read_color(file);
  const double factor = std::min(1.0, static_cast<double>(kThumbnail_px) / std::max(1, image.height()));
  const auto side = [&](int n) { return std::max(1, static_cast<int>(std::lround(n * factor))); };
  write_srgb8(scratch, downscale_area(image, side(image.width()), side(image.height())));
  std::string uri = data_uri(fs::path(scratch));
  fs::remove(scratch);
  return uri;
}

using Rows = std::pair<std::vector<std::string>, std::vector<std::vector<std::string>>>;
using TextPairs = std::vector<std::pair<std::string, std::string>>;

/// @param blocks  ("paragraph", text), ("table", (header, rows)), ... from top to bottom.
std::string page_text(const std::string& title, const std::vector<std::pair<std::string, py::object>>& blocks) {
  HtmlPage page(title);
  for (const auto& [kind, given] : blocks) {
    if (kind == "heading") page.heading(py::cast<std::string>(given));
    if (kind == "paragraph") page.paragraph(py::cast<std::string>(given));
    if (kind == "code") page.code(py::cast<std::string>(given));
    if (kind == "link") {
      const auto [target, text] = py::cast<std::pair<std::string, std::string>>(given);
      page.link(target, text);
    }
    if (kind == "table") {
      const auto [header, rows] = py::cast<Rows>(given);
      page.table(header, rows);
    }
    if (kind == "pictures") {
      std::vector<HtmlPicture> pictures;
      for (const auto& [source, caption] : py::cast<TextPairs>(given)) pictures.push_back({source, caption});
      page.pictures(pictures);
    }
  }
  return page.text();
}

}  // namespace

void bind_study(py::module_& module) {
  bind_json(module);
  bind_numbers(module);
  module.attr("_FILE_NAME") = file_name_text();
  module.def("_is_file_name", [](const std::string& name) { return is_file_name(name); });
  module.def("_is_temporary", [](const std::string& name) { return is_temporary(name); });
  module.def("_did_you_mean",
             [](const std::string& word, const std::vector<std::string>& names) { return did_you_mean(word, names); });
  module.def("_number_text", &number_text);
  module.def("_figure_text", [](double value) { return short_number_text(rounded(value, 4)); });
  module.def("_printable", [](const std::string& text) { return printable_lines(text); });
  module.def("_require_exists", [](const std::string& path) { app::require_exists(path); });
  module.def("_library_place", [](const std::string& path) { return app::library_place(path).string(); });
  module.def("_list_files", [](const std::string& folder, const std::string& pattern) {
    std::vector<std::string> names;
    for (const fs::path& file : list_files(folder, pattern)) names.push_back(file.filename().string());
    return names;
  });
  module.def("_control_problem", [](const std::string& place, const std::vector<std::string>& controls) {
    std::optional<HistoryReader> history;
    try {
      history.emplace(app::history_place(place));
      (void)transfer::with_sources(*history, transfer::parse_controls(controls));
    } catch (const InputError& e) {
      return history ? std::string(e.what()) : std::string();  // What cannot be read is said by the cell that needs it.
    }
    return std::string();
  });
  module.def("_control_files", [](const std::string& text) {
    std::vector<std::string> files;
    const ControlExpression expression(transfer::parse_control_spec(text).destination, control_kind_names());
    for (const ControlName& name : expression.names()) {
      if (name.is_file) files.push_back(name.text);
    }
    return files;
  });
  module.def("_write", [](const std::string& path, const std::string& text) { write_atomically(path, text); });
  module.def("_save_json",
             [](const std::string& path, const py::object& json) { save_json(path, json_from(json, "study")); });
  module.def("_thumbnail", &thumbnail);
  module.def("_page", &page_text);
}

}  // namespace patinate::python
