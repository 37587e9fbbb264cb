#include "analysis/factorization/frame_record.h"

#include <nlohmann/json.hpp>

namespace patinate::analysis {

Json frame_json(const FrameRecord& frame) {
  Json json{{"time", frame.time}};
  if (frame.covered_share) {
    json["extrapolated"] = true;
    json["covered_share"] = *frame.covered_share;
    if (frame.is_held) json["held"] = true;
  }
  if (frame.error) {
    json["pixels"] = frame.error->num_pixels;
    json["rmse"] = frame.error->rmse;
    if (frame.error->is_color) {
      json["ciede2000_mean"] = frame.error->ciede2000_mean;
      json["ciede2000_p95"] = frame.error->ciede2000_p95;
    }
  }
  return json;
}

FrameRecord frame_from_json(const Json& json) {
  FrameRecord frame{.time = json.at("time"), .covered_share = {}, .is_held = json.value("held", false), .error = {}};
  if (json.contains("covered_share")) frame.covered_share = json.at("covered_share").get<double>();
  if (json.contains("rmse"))
    frame.error = FrameError{.num_pixels = json.at("pixels"),
                             .rmse = json.at("rmse"),
                             .ciede2000_mean = json.value("ciede2000_mean", 0.0),
                             .ciede2000_p95 = json.value("ciede2000_p95", 0.0),
                             .is_color = json.contains("ciede2000_mean")};
  return frame;
}

}  // namespace patinate::analysis
