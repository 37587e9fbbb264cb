#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/request/output_file.h"
#include "app/request/usage_error.h"
#include "capture/thickness/thickness_warnings.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_documents.h"
#include "patinate/capture/thickness.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/output_command.h"

namespace patinate::cli {

namespace {

struct ThicknessCommandOptions {
  capture::ThicknessOptions thickness;
};
void describe(OptionVisitor& v, ThicknessCommandOptions& o) { describe(v, o.thickness); }

Response response_of(const std::string& text) {
  if (text == "file") return {};
  if (text == "srgb") return {.kind = Response::Kind::Srgb};
  if (text == "linear") return {.kind = Response::Kind::Linear};
  const std::optional<double> gamma = parse_number(text);
  if (!gamma || !(*gamma > 0 && *gamma <= 10))
    throw app::UsageError("--response: found `" + text + "`; expected file, srgb, linear or a gamma in (0, 10]");
  return {.kind = Response::Kind::Gamma, .gamma = *gamma};
}

/// Brightness of the transmitted light, H x W x 1.
ImageF read_light(const std::filesystem::path& path, const Response& response) {
  const ImageF color = read_color(path, response);
  ImageF light(color.width(), color.height());
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) light.at(x, y) = luminance(color.pixel(x, y));
  }
  return light;
}

}  // namespace

int cmd_thickness(CommandRun& run) {
  std::filesystem::path photo, blank, mask, output;
  std::string response = "file";
  ThicknessCommandOptions options;
  run.line.positional("PHOTO", "Photograph of the light that the layer lets through", photo);
  run.line.option("blank", "IMAGE", "The same without the layer: its light is divided out", blank);
  run.line.option("mask", "IMAGE", "0 = outside: frame, saturated and opaque parts", mask);
  run.line.option(
      "response", "CURVE",
      "How codes become linear: as the file says (srgb where it says nothing), srgb, linear, or a gamma such as 2.2",
      response);
  run.line.output("MAP.exr", "Control map to make: float, channel Y, [0, 1]", output);
  run.line.options(options);
  run.line.example("thickness backlight.png --blank lightbox.png -o thickness.exr");
  if (!run.parse()) return 0;
  app::require_extension(output, {".exr"});
  const Response curve = response_of(response);

  ContentHash hash;
  hash.add("thickness 3").add(curve.text()).add_file(photo);
  hash.add(blank.empty() ? "no blank" : "blank").add(mask.empty() ? "no mask" : "mask");
  if (!blank.empty()) hash.add_file(blank);
  if (!mask.empty()) hash.add_file(mask);
  for (const auto& [name, value] : option_values(options)) hash.add(name).add(value);
  const std::string key = hash.hex();
  const std::optional<JobStatus> status = run.check_file(output, app::image_file_key(output), key);
  if (!status) return 0;
  if (*status == JobStatus::UpToDate) {
    run.report_output(*status, output);
    return 0;
  }
  capture::ThicknessMap map;
  try {
    map = capture::thickness_from_transmission(
        read_light(photo, curve), blank.empty() ? ImageF() : read_light(blank, curve),
        mask.empty() ? ImageU8() : read_mask(mask), options.thickness, run.control("thickness"));
  } catch (const InvalidInput& e) {
    throw IoError(photo.string(), e.what());
  }
  const double span = map.high - map.low;
  std::int64_t num_known = 0;
  for (std::int64_t i = 0; i < map.values.num_pixels(); ++i) {
    float& v = map.values.data()[i];
    const bool is_known = map.known.data()[i] != 0;
    num_known += is_known;
    v = is_known && span > 0 ? static_cast<float>(std::clamp((static_cast<double>(v) - map.low) / span, 0.0, 1.0))
                             : 0.0f;
  }
  write_scaled_exr(output, map.values, {map.low, map.high, "relative"}, key);
  if (map.low > 0.0 && map.high / map.low > 50.0) {
    run.note("thickness spans 1 to " + short_number_text(map.high / map.low) +
             ": saturated or opaque parts belong outside the --mask");
  }
  const capture::LayerEvidence& seen = map.evidence;
  const std::vector<HistoryWarning> warnings =
      capture::thickness_warnings(seen, photo.filename().string(), options.thickness);
  for (const HistoryWarning& warning : warnings) run.warn(warning_text(warning));
  if (map.window.is_chosen) run.note(capture::layer_window_text(map.window));
  run.note("the commonest value covers " + fixed_percent_text(seen.share) + " of its window in the median, less than " +
           "half in " + fixed_percent_text(seen.weak_share) + " of the layer; two values compete in " +
           fixed_percent_text(seen.two_modes));
  run.detail("0 stands for " + number_text(map.low) + ", 1 for " + number_text(map.high) + " (relative)");
  run.report_output(*status, output,
                    Json{{"range", {map.low, map.high}},
                         {"unit", "relative"},
                         {"known", num_known},
                         {"mode_share", seen.share},
                         {"weak_share", seen.weak_share},
                         {"two_modes_share", seen.two_modes},
                         {"hole_share", seen.hole_share},
                         {"window_px", map.window.sigma_px},
                         {"foretold_to", map.window.is_chosen ? Json(map.window.foretold_to) : Json()},
                         {"warnings", warnings_json(warnings)}});
  return 0;
}

}  // namespace patinate::cli
