#include "tools/patinate/services/calibration_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/geometry/light_io.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/output_file.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/usage_error.h"

namespace patinate::cli {

namespace {

std::string name_of(capture::CalibrationKind kind) {
  return std::string(capture::kCalibrationKindNames[static_cast<std::size_t>(kind)]);
}

std::string file_text(const capture::CalibrationOutput& result, capture::CalibrationKind kind,
                      const std::filesystem::path& output) {
  const std::string extension = lower_extension(output);
  if (extension == ".yml") {
    if (kind != capture::CalibrationKind::Camera)
      throw UsageError("-o *.yml holds a camera, which `calibrate " + name_of(kind) + "` does not find; use .json");
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

void require_calibration_names(const std::filesystem::path& output, const std::filesystem::path& picture) {
  if (!output.empty()) require_extension(output, {".json", ".yml", ".lp"});
  if (!picture.empty()) require_extension(picture, {".png"});
}

OutputWork calibration_work(const capture::CalibrationOutput& result, capture::CalibrationKind kind,
                            const std::filesystem::path& output) {
  const std::string text = file_text(result, kind, output);
  std::error_code error;
  const bool is_same = std::filesystem::is_regular_file(output, error) && read_file(output) == text;
  OutputWork work{.output = output,
                  .label = "calibrate " + name_of(kind),
                  .key = "same",
                  .existing_key = is_same ? "same" : "",
                  .report = nullptr};
  work.make = [output, text](const RunControl&) { write_atomically(output, text); };
  return work;
}

void write_calibration_picture(const capture::CalibrationOutput& result, capture::CalibrationKind kind,
                               const std::filesystem::path& picture) {
  if (result.picture.empty()) throw UsageError("--picture: `calibrate " + name_of(kind) + "` draws none");
  write_srgb8(picture, result.picture);
}

}  // namespace patinate::cli
