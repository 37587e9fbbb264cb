#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/calibration/calibrate_kinds.h"
#include "libcommon/core/text.h"
#include "libcommon/image/response_io.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace {

/// The codes of a photograph as they are, one channel: the mean of red, green and blue would mix codes, so green is
/// taken.
ImageU8 read_codes(const std::filesystem::path& path) {
  const ImageInfo info = probe_image(path);
  if (!info.is_integer || info.is_raw)
    throw IoError(path.string(), "holds linear values; a response is that of 8-bit photographs");
  const bool has_green = info.channels.size() >= 3;
  const ImageF codes = has_green ? read_channels(path, {info.channels[1]}) : read_gray(path, info.channels[0]);
  ImageU8 result(codes.width(), codes.height());
  for (std::int64_t i = 0; i < codes.num_pixels(); ++i)
    result.data()[i] = static_cast<std::uint8_t>(std::lround(255.0f * codes.data()[i]));
  return result;
}

}  // namespace

CalibrationOutput run_response(JsonReader& json, const ResponseOptions& options) {
  std::vector<ImageU8> photos;
  std::vector<double> exposures;
  for (JsonReader& entry : json.member("photos").elements(100)) {
    photos.push_back(read_codes(entry.member("photo").path()));
    exposures.push_back(entry.member("exposure").number(above(0)));
    entry.finish();
  }
  json.finish();
  const ResponseCurve curve = recover_response(photos, exposures, options);
  if (curve.status != ResponseStatus::Converged) {
    throw CannotComplete("the photographs show codes " + std::to_string(curve.low_code) + " to " +
                         std::to_string(curve.high_code) +
                         " only, which leaves the response open; add shorter or longer exposures");
  }
  // Root mean square difference from a named curve, of full scale, below which it is named.
  constexpr double kFits = 0.015;
  CalibrationOutput output;
  output.json = std::make_shared<Json>(result_json(CalibrationKind::Response));
  const bool fits = curve.closest_rms < kFits;
  if (fits) (*output.json)["response"] = json_of(curve.closest);
  (*output.json)["report"] = {{"closest", curve.closest.text()},
                              {"rms", curve.closest_rms},
                              {"codes", {curve.low_code, curve.high_code}},
                              {"linear", curve.linear}};
  output.lines.push_back("nearest: " + curve.closest.text() + ", off by " + percent_text(curve.closest_rms, 2) +
                         " rms");
  if (!fits)
    output.lines.push_back(
        "none of srgb, linear and gamma is this camera's response: use linear (RAW or EXR) photographs");
  return output;
}

}  // namespace patinate::capture
