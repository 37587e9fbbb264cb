#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/calibration/calibration_file.h"
#include "patinate/core/json.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

int cmd_calibrate(CommandRun& run) {
  std::string kind_name;
  std::filesystem::path description, output, picture;
  capture::CalibrateOptions options;
  run.line.positional("KIND",
                      "camera (from a target), spheres (lights from mirror spheres), lambertian (lights from a diffuse "
                      "object) or response",
                      kind_name);
  const std::vector<std::string> kinds(capture::kCalibrationKindNames.begin(), capture::kCalibrationKindNames.end());
  run.line.choices(kinds);
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
  run.line.written();
  run.line.example("calibrate camera board.json -o camera.json --picture residuals.png");
  run.line.example("calibrate spheres rig.json -o lights.json");
  run.line.example("calibrate spheres rti.json -o lights.lp");
  if (!run.parse()) return 0;
  app::require_calibration_names(output, picture);
  const auto kind =
      static_cast<capture::CalibrationKind>(std::find(kinds.begin(), kinds.end(), kind_name) - kinds.begin());

  const Json content = load_json(description);
  const capture::CalibrationOutput result = capture::calibrate(kind, JsonReader(description.string(), content), options,
                                                               run.control("calibrate " + kind_name));
  const app::OutputWork work = app::calibration_work(result, kind, output, picture);
  const std::optional<JobStatus> status = run.check_files(app::files_of(work), work.key);
  if (!status) return 0;
  if (*status == JobStatus::Done) work.make({});
  for (const std::string& line : result.lines) run.note(line);
  Json more{{"kind", kind_name}, {"report", result.json->at("report")}, {"notes", result.lines}};
  for (const char* part : {"camera", "lights", "response"}) {
    if (result.json->contains(part)) more[part] = result.json->at(part);
  }
  run.report_output(*status, output, more);
  return 0;
}

}  // namespace patinate::cli
