#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/calibration/calibrate.h"
#include "libcommon/core/files.h"
#include "libcommon/geometry/light_io.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

const std::vector<std::string> kKinds{"camera", "spheres", "lambertian", "response"};

/// What goes into the output, in the form that its extension asks for.
std::string file_text(const capture::CalibrationOutput& result, capture::CalibrationKind kind,
                      const std::filesystem::path& output) {
  const std::string extension = lower_extension(output);
  if (extension == ".yml") {
    if (kind != capture::CalibrationKind::Camera)
      throw UsageError("-o *.yml holds a camera, which `calibrate " + kKinds[static_cast<std::size_t>(kind)] +
                       "` does not find; use .json");
    return opencv_text(*result.camera);
  }
  if (extension == ".lp") {
    const bool are_directions = std::all_of(result.lights.begin(), result.lights.end(),
                                            [](const Light& l) { return l.kind == Light::Kind::Directional; });
    if (result.lights.empty() || !are_directions)
      throw UsageError("-o *.lp holds directions of lights; these are positions or no lights, use .json");
    return lp_text(result.lights, *result.camera);
  }
  return result.json->dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

int cmd_calibrate(CommandRun& run) {
  std::string kind_name;
  std::filesystem::path description, output, picture;
  capture::CalibrateOptions options;
  run.line.positional("KIND",
                      "camera (from a target), spheres (lights from mirror spheres), lambertian (lights from a diffuse "
                      "object) or response",
                      kind_name);
  run.line.choices(kKinds);
  run.line.positional("DESCRIPTION", "JSON file that names the photographs (docs/calibration.md)", description);
  run.line.output("RESULT",
                  "Calibration to write: .json, which `camera` and `lights` of a project take; .yml for a camera; .lp "
                  "for directions of lights",
                  output);
  // Each kind has options of its own, so the kind decides what --help lists and what is accepted.
  const std::string asked = run.first_positional();
  if (asked == "camera") run.line.options(options.camera);
  if (asked == "spheres") run.line.options(options.spheres);
  if (asked == "lambertian") run.line.options(options.lambertian);
  if (asked == "response") run.line.options(options.response);
  run.line.option("picture", "FILE.png", "Also draw residuals (camera) or outlines and highlights (spheres)", picture);
  run.line.example("calibrate camera board.json -o camera.json --picture residuals.png");
  run.line.example("calibrate spheres rig.json -o lights.json");
  run.line.example("calibrate spheres rti.json -o lights.lp");
  if (!run.parse()) return 0;
  require_extension(output, {".json", ".yml", ".lp"});
  if (!picture.empty()) require_extension(picture, {".png"});
  const auto kind =
      static_cast<capture::CalibrationKind>(std::find(kKinds.begin(), kKinds.end(), kind_name) - kKinds.begin());

  const Json content = load_json(description);
  const capture::CalibrationOutput result = capture::calibrate(kind, JsonReader(description.string(), content), options,
                                                               run.control("calibrate " + kind_name));
  const std::string text = file_text(result, kind, output);
  std::error_code error;
  const bool is_same = std::filesystem::is_regular_file(output, error) && read_file(output) == text;
  const std::optional<JobStatus> status = run.check_file(output, is_same ? "same" : "", "same");
  if (!status) return 0;
  if (*status == JobStatus::Done) write_atomically(output, text);
  if (!picture.empty()) {
    if (result.picture.empty()) throw UsageError("--picture: `calibrate " + kind_name + "` draws none");
    write_srgb8(picture, result.picture);
  }
  for (const std::string& line : result.lines) run.note(line);
  Json more{{"kind", kind_name}, {"report", result.json->at("report")}, {"notes", result.lines}};
  for (const char* part : {"camera", "lights", "response"}) {
    if (result.json->contains(part)) more[part] = result.json->at(part);
  }
  run.report_output(*status, output, more);
  return 0;
}

}  // namespace patinate::cli
