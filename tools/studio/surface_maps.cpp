// Maps of a surface: controls, what is constant, what its frames hold beside color, and the amounts of a simulation.
#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"
#include "tools/studio/surface_in_time.h"

namespace patinate::studio {

namespace {

ImageF mask_values(const ImageU8& mask) {
  ImageF out(mask.width(), mask.height(), 1);
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) out.data()[i] = mask.data()[i] != 0 ? 1.0f : 0.0f;
  return out;
}

/// Of a constant map, or one of a frame.
std::string unit_of_map(const std::string& name) {
  return name == "height" || name == "texel_size" || name == "position" ? "mm" : "";
}

std::optional<MaterialMap> material_map_named(const std::string& name) {
  const auto found = std::find(kMaterialMapNames.begin(), kMaterialMapNames.end(), name);
  if (found == kMaterialMapNames.end()) return std::nullopt;
  return static_cast<MaterialMap>(found - kMaterialMapNames.begin());
}

}  // namespace

std::vector<std::string> SurfaceInTime::frame_maps() const {
  std::vector<std::string> names;
  for (const FrameFacts& frame : history_->facts().frames) {
    for (const std::string& extra : frame.extras) {
      // The highlight of a frame is its strength and its roughness.
      for (const char* name : {extra.c_str(), "roughness"}) {
        const bool is_of_it = name == extra || extra == "specular";
        if (is_of_it && std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
      }
    }
  }
  return names;
}

std::vector<std::string> SurfaceInTime::amounts() const {
  for (const HistoryFrame& frame : history_->manifest().frames) {
    if (frame.amounts) return probe_image(history_->folder() / *frame.amounts).channels;
  }
  return {};
}

ImageF SurfaceInTime::amounts_of_frame(int index, const std::vector<std::string>& materials) const {
  const HistoryFrame& frame = history_->manifest().frames.at(static_cast<std::size_t>(index));
  if (!frame.amounts) throw InvalidInput("frame " + std::to_string(index) + " has no amounts");
  return read_channels(history_->folder() / *frame.amounts, materials);
}

ImageF SurfaceInTime::amount_at(const std::string& material, double time) const {
  const TimePosition at = locate(*history_, time, Between::Blend);
  ImageF amount = amounts_of_frame(at.index, {material});
  if (at.fraction == 0.0) return amount;
  const ImageF next = amounts_of_frame(at.index + 1, {material});
  const auto share = static_cast<float>(at.fraction);
  std::transform(amount.values().begin(), amount.values().end(), next.values().begin(), amount.values().begin(),
                 [share](float a, float b) { return (1.0f - share) * a + share * b; });
  return amount;
}

NamedMap SurfaceInTime::map(const std::string& name, double time) const {
  const HistoryManifest& m = history_->manifest();
  const std::size_t colon = name.find(':');
  const std::string kind = name.substr(0, colon), what = colon == std::string::npos ? "" : name.substr(colon + 1);
  if (kind == "control") {
    const ControlFacts& c = history_->control(what);
    return {spread(history_->read_control(what), {}), c.low, c.high, c.unit};
  }
  if (kind == "map") return {spread(history_->read_map(what), {}), 0.0, 1.0, unit_of_map(what)};
  if (const auto map = material_map_named(what); kind == "frame" && map)
    return {spread(sample_material_map(*history_, *map, time, Between::Blend), {}), 0.0, 1.0, unit_of_map(what)};
  const std::vector<std::string> materials = kind == "amount" ? amounts() : std::vector<std::string>();
  if (std::find(materials.begin(), materials.end(), what) != materials.end())
    return {spread(amount_at(what, time), {}), 0.0, 1.0, "amount"};
  if (kind == "mask") {
    const std::optional<double> index = parse_number(what);
    if (!index || *index != std::floor(*index) || !(*index >= 0 && *index < history_->num_frames())) {
      throw InvalidInput("mask: found \"" + what + "\"; expected the number of a frame, 0 to " +
                         std::to_string(history_->num_frames() - 1));
    }
    return {spread(mask_values(history_->read_frame_mask(static_cast<int>(*index))), {}), 0.0, 1.0, ""};
  }
  if (name == "coverage") return {mask_values(transfer_ ? transfer_->coverage() : history_->read_mask()), 0.0, 1.0, ""};
  if (name == "coordinates" && transfer_) return {transfer_->coordinates(), 0.0, 1.0, "px"};
  std::string known = "coverage, mask:FRAME";
  if (transfer_) known += ", coordinates";
  for (const ControlParameter& c : m.controls) known += ", control:" + c.name;
  for (const HistoryMap& map : m.maps) known += ", map:" + map.name;
  for (const std::string& of_frames : frame_maps()) known += ", frame:" + of_frames;
  for (const std::string& material : amounts()) known += ", amount:" + material;
  throw InvalidInput("there is no map \"" + name + "\"; there are " + known);
}

/// Everything that is known of one pixel of the history beside its color.
void SurfaceInTime::add_values(const NearestPixel& at, TexelCurve& curve, const RunControl& control) const {
  const HistoryManifest& m = history_->manifest();
  const auto value_of = [&at](const ImageF& image, int channel) {
    return static_cast<double>(image.at(at.x, at.y, channel));
  };
  for (const ControlParameter& c : m.controls) {
    const auto image = kept("control " + c.name, [&] { return history_->read_control(c.name); });
    curve.constants.push_back({c.name, c.unit, c.low + value_of(*image, 0) * (c.high - c.low)});
  }
  for (const HistoryMap& map : m.maps) {
    const auto image = kept("map " + map.name, [&] { return history_->read_map(map.name); });
    if (image->channels() == 1) curve.constants.push_back({map.name, unit_of_map(map.name), value_of(*image, 0)});
  }
  const std::vector<std::string> materials = amounts();
  for (const std::string& material : materials) curve.values.push_back({material, "amount", {}});
  std::vector<std::string> extras;
  for (const std::string& name : frame_maps()) {
    if (name == "height" || name == "metalness") extras.push_back(name);
  }
  for (const std::string& name : extras) curve.values.push_back({name, unit_of_map(name), {}});
  for (int f = 0; f < history_->num_frames(); ++f) {
    control.throw_if_stopped();
    const HistoryFrame& frame = m.frames[static_cast<std::size_t>(f)];
    std::size_t number = 0;
    const auto add = [&](std::optional<double> value) { curve.values[number++].values.push_back(value); };
    std::shared_ptr<const ImageF> all;
    if (frame.amounts) all = kept("amounts " + std::to_string(f), [&] { return amounts_of_frame(f, materials); });
    for (std::size_t i = 0; i < materials.size(); ++i)
      add(all ? std::optional(value_of(*all, static_cast<int>(i))) : std::nullopt);
    for (const std::string& name : extras) {
      const bool is_known = std::any_of(frame.extras.begin(), frame.extras.end(),
                                        [&](const HistoryImage& extra) { return extra.name == name; });
      const auto read = [&] { return history_->read_frame_extra(f, name).value(); };
      add(is_known ? std::optional(value_of(*kept(name + " " + std::to_string(f), read), 0)) : std::nullopt);
    }
  }
}

}  // namespace patinate::studio
