#include "capture/calibration/calibrate.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "python/bindings.h"
#include "python/support/json.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

using capture::CalibrateOptions;
using capture::CalibrationKind;

/// Options of a kind are a member of CalibrateOptions.
template <auto Member>
using OptionsOf = std::decay_t<decltype(std::declval<CalibrateOptions>().*Member)>;

template <auto Member>
void define_kind(py::module_& module, CalibrationKind kind, const std::string& brief, const std::string& found) {
  const std::string name = "calibrate_" + std::string(capture::kCalibrationKindNames[static_cast<std::size_t>(kind)]);
  const FunctionText text =
      FunctionText(name, brief + ": `patinate calibrate`, each kind of which has options of its own.")
          .takes("description", "str | os.PathLike[str] | dict[str, Any]",
                 "A JSON file that names the photographs (docs/calibration.md), or what it would hold")
          .keyword("folder", "str | os.PathLike[str]", "'.'",
                   "Of a description that is no file: what its paths lead from")
          .keyword("output", "str | os.PathLike[str] | None", "None",
                   "Also write the calibration: .json, which `camera` and `lights` of a project take; .yml for a "
                   "camera; .lp for directions of lights")
          .keyword("picture", "str | os.PathLike[str] | None", "None",
                   "Also write a .png of residuals (camera) or of outlines and highlights (spheres)")
          .keyword("force", "bool", "False", "Replace something different that lies there")
          .template options<OptionsOf<Member>>()
          .runs()
          .returns("Report", found)
          .raises(
              "IoError for the description or a file it names; InvalidInput; CannotComplete where the data leave "
              "the result open: the line says what would help");
  define(module, text, [name, kind](const py::object& given, const py::kwargs& kwargs) {
    Keywords keywords(name, kwargs);
    CalibrateOptions options;
    keywords.read(options.*Member);
    const std::string folder = keywords.text("folder", ".");
    const std::string output = keywords.text("output", ""), picture = keywords.text("picture", "");
    const bool force = keywords.flag("force", false);
    const RunArguments run = keywords.run();
    keywords.finish();
    app::require_calibration_names(output, picture);
    const bool is_dict = py::isinstance<py::dict>(given);
    const std::filesystem::path file =
        is_dict ? std::filesystem::path(folder) / "description" : std::filesystem::path(path_from(given));
    const Json held = is_dict ? json_from(given, "description") : Json();
    const capture::CalibrationOutput calibration = result_of(run, [=](const RunControl& control) {
      const Json content = is_dict ? held : load_json(file);
      capture::CalibrationOutput result =
          capture::calibrate(kind, JsonReader(file.string(), content), options, control);
      if (!output.empty() || !picture.empty())
        app::make_output(app::calibration_work(result, kind, output, picture), force, {});
      return result;
    });
    return py::cast<py::dict>(object_of(*calibration.json));
  });
}

}  // namespace

void bind_calibrate(py::module_& module) {
  define_kind<&CalibrateOptions::camera>(module, CalibrationKind::Camera,
                                         "Finds a camera's lens from photographs of a flat target",
                                         "camera (pinhole and distortion, px) and report, as in the file");
  define_kind<&CalibrateOptions::spheres>(module, CalibrationKind::Spheres,
                                          "Finds lights from their highlights on mirror spheres",
                                          "lights (positions in mm, or directions) and report, as in the file");
  define_kind<&CalibrateOptions::lambertian>(module, CalibrationKind::Lambertian,
                                             "Finds lights from the shading of a diffuse object of known shape",
                                             "lights (positions in mm, strengths) and report, as in the file");
  define_kind<&CalibrateOptions::response>(module, CalibrationKind::Response,
                                           "Finds a camera's response curve from an exposure series",
                                           "response and report, as in the file");
}

}  // namespace patinate::python
