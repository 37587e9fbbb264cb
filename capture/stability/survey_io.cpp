#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/stability/survey.h"

namespace patinate::capture {

Json pair_to_json(const FramePair& pair) {
  Json json;
  json["reference"] = pair.reference;
  json["frame"] = pair.frame;
  json["shift"] = {pair.shift.x, pair.shift.y};
  json["status"] = static_cast<int>(pair.shift.status);
  json["agreement"] = pair.shift.agreement;
  json["peak"] = pair.shift.peak;
  json["similarity_before"] = pair.similarity_before;
  if (pair.is_motion_measured) {
    const auto& m = pair.motion.frame_from_reference;
    json["motion"] = {{"matrix", {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2)}},
                      {"similarity", pair.motion.similarity},
                      {"residual_px", pair.motion.residual_px},
                      {"is_reliable", pair.motion.is_reliable}};
  }
  json["log_gain"] = pair.change.log_gain;
  const LightChange& light = pair.change.light;
  json["light"] = {{"log_gain", light.log_gain}, {"share", light.share}, {"width", light.width}};
  json["surface_change"] = pair.change.surface;
  json["contrast"] = pair.contrast;
  return json;
}

FramePair pair_from_json(JsonReader json) {
  FramePair pair;
  pair.reference = static_cast<int>(json.member("reference").integer(between(0, 1e9)));
  pair.frame = static_cast<int>(json.member("frame").integer(between(0, 1e9)));
  const std::vector<double> shift = json.member("shift").numbers(2);
  pair.shift.x = shift[0];
  pair.shift.y = shift[1];
  pair.shift.status = static_cast<ShiftStatus>(json.member("status").integer(between(0, 2)));
  pair.shift.agreement = json.member("agreement").number();
  pair.shift.peak = json.member("peak").number();
  pair.similarity_before = json.member("similarity_before").number();
  if (json.has("motion")) {
    JsonReader motion = json.member("motion");
    const std::vector<double> m = motion.member("matrix").numbers(6);
    pair.motion.frame_from_reference.matrix().topRows<2>() << m[0], m[1], m[2], m[3], m[4], m[5];
    pair.motion.similarity = motion.member("similarity").number();
    pair.motion.residual_px = motion.member("residual_px").number();
    pair.motion.is_reliable = motion.member("is_reliable").boolean();
    pair.is_motion_measured = true;
    motion.finish();
  }
  const std::vector<double> gain = json.member("log_gain").numbers(3);
  for (std::size_t c = 0; c < 3; ++c) pair.change.log_gain[c] = gain[c];
  if (json.has("light")) {
    JsonReader light = json.member("light");
    const std::vector<double> shared = light.member("log_gain").numbers(3);
    std::copy_n(shared.begin(), 3, pair.change.light.log_gain.begin());
    pair.change.light.share = light.member("share").number(between(0, 1));
    pair.change.light.width = light.member("width").number(between(0, 1));
    light.finish();
  }
  pair.change.surface = json.member("surface_change").number();
  if (json.has("contrast")) {
    const std::vector<double> contrast = json.member("contrast").numbers(2, at_least(0));
    std::copy_n(contrast.begin(), 2, pair.contrast.begin());
  }
  json.finish();
  return pair;
}

Json finding_to_json(const FrameFinding& f) {
  Json json;
  json["frame"] = f.frame;
  json["odd_frame"] = f.odd_frame;
  json["problem"] = finding_text(f);
  const FindingTexts texts = finding_texts(f);
  json["problems"] = Json::object();
  if (!texts.moved.empty()) json["problems"]["moved"] = texts.moved;
  if (!texts.exposed.empty()) json["problems"]["exposed"] = texts.exposed;
  if (!texts.unclear.empty()) json["problems"]["unclear"] = texts.unclear;
  if (!texts.jump.empty()) json["problems"]["jump"] = texts.jump;
  if (!texts.unmatched.empty()) json["problems"]["unmatched"] = texts.unmatched;
  json["similarity"] = f.similarity;
  if (f.is_shifted) {
    json["shift_px"] = {f.shift_x, f.shift_y};
    json["turn_deg"] = f.turn_deg;
    json["size"] = f.size;
  }
  if (f.is_exposure_changed) json["gain"] = f.gain;
  if (f.is_light_unclear) json["unclear_gain"] = f.gain;
  if (f.is_jump) json["change_factor"] = f.change_factor;
  return json;
}

}  // namespace patinate::capture
