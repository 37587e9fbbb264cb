#include "app/calibration/calibration_file.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/geometry/light_io.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::app {

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

std::string picture_key(const ImageU8& codes) {
  ContentHash hash;
  hash.add("calibration picture").add(std::int64_t{codes.width()}).add(std::int64_t{codes.height()});
  return hash.add(std::string_view(reinterpret_cast<const char*>(codes.data()), codes.values().size())).hex();
}

}  // namespace

void require_calibration_names(const std::filesystem::path& output, const std::filesystem::path& picture) {
  if (!output.empty()) require_extension(output, {".json", ".yml", ".lp"});
  if (!picture.empty()) require_extension(picture, {".png"});
}

OutputWork calibration_work(const capture::CalibrationOutput& result, capture::CalibrationKind kind,
                            const std::filesystem::path& output, const std::filesystem::path& picture) {
  std::vector<OutputFile> files;
  std::vector<std::function<void()>> writes;
  if (!output.empty()) {
    const std::string text = file_text(result, kind, output);
    files.push_back(text_file(output, text));
    writes.emplace_back([output, text] { write_atomically(output, text); });
  }
  if (!picture.empty()) {
    if (result.picture.empty()) throw UsageError("--picture: `calibrate " + name_of(kind) + "` draws none");
    const ImageU8 codes = srgb8_from_linear(result.picture);
    const std::string key = picture_key(codes);
    files.push_back({.path = picture, .existing_key = image_file_key(picture) == key ? kSameText : ""});
    writes.emplace_back([picture, codes, key] { write_codes(picture, codes, key); });
  }
  OutputWork work{.output = files.front().path,
                  .label = "calibrate " + name_of(kind),
                  .key = kSameText,
                  .existing_key = files.front().existing_key,
                  .report = nullptr};
  work.beside.assign(files.begin() + 1, files.end());
  work.make = [writes](const RunControl&) {
    for (const auto& write : writes) write();
  };
  return work;
}

}  // namespace patinate::app
