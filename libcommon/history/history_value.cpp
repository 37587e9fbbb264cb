#include "patinate/history/history_value.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// "are none", or "is: a, b".
std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "are none" : "is: " + list;
}

}  // namespace

const std::vector<std::string>& frame_extra_channels(const std::string& name) {
  static const std::array<std::vector<std::string>, 6> kChannels{
      {{"R", "G", "B"}, {"strength", "roughness"}, {"X", "Y", "Z"}, {"Y"}, {"Y"}, {"R", "G", "B"}}};
  const auto* const found = std::find(kFrameExtraNames.begin(), kFrameExtraNames.end(), name);
  if (found == kFrameExtraNames.end())
    throw InvalidInput("`" + name + "` of a frame: use stddev, specular, normal, height, metalness or tint");
  return kChannels[found - kFrameExtraNames.begin()];
}

const std::vector<std::string>& history_map_channels(const std::string& name) {
  static const std::vector<std::string> kVector{"X", "Y", "Z"}, kNumber{"Y"};
  const auto* const found = std::find(kHistoryMapNames.begin(), kHistoryMapNames.end(), name);
  if (found == kHistoryMapNames.end())
    throw InvalidInput("map `" + name + "`: use position, normal, height, texel_size, specular, metalness or tint");
  if (name == "specular" || name == "tint") return frame_extra_channels(name);
  return found - kHistoryMapNames.begin() < 2 ? kVector : kNumber;
}

std::string warning_text(const HistoryWarning& warning) {
  return warning.cure.empty() ? warning.text : warning.text + "; what helps: " + warning.cure;
}

void sort_warnings(std::vector<HistoryWarning>& warnings) {
  std::stable_sort(warnings.begin(), warnings.end(),
                   [](const HistoryWarning& a, const HistoryWarning& b) { return a.share > b.share; });
}

void check_material_maps(const HistoryFacts& facts) {
  for (const std::string name : {"specular", "metalness", "tint"}) {
    const auto is_there = [&](const FrameFacts& frame) {
      return std::find(frame.extras.begin(), frame.extras.end(), name) != frame.extras.end();
    };
    const auto with = std::find_if(facts.frames.begin(), facts.frames.end(), is_there);
    if (with == facts.frames.end()) continue;
    if (std::find(facts.maps.begin(), facts.maps.end(), name) != facts.maps.end())
      throw InvalidInput("`" + name + "`: is given for frames and as a map that is constant; leave one of them out");
    const auto without = std::find_if_not(facts.frames.begin(), facts.frames.end(), is_there);
    if (name == "specular" || without == facts.frames.end()) continue;
    throw InvalidInput("`" + name + "`: frame " + std::to_string(without - facts.frames.begin()) + " has none, frame " +
                       std::to_string(with - facts.frames.begin()) + " has; give it for all frames or for none");
  }
}

void check_library_parts(const HistoryFacts& facts) {
  if (facts.parts.empty()) return;
  int begin = 0;
  for (const LibraryPart& part : facts.parts) {
    if (part.x < begin || part.width < 1 || part.height < 1 || part.x > facts.width - part.width ||
        part.height > facts.height) {
      throw InvalidInput("library: `" + part.name + "` lies outside of the history's " +
                         size_text(facts.width, facts.height) + " pixels, or over the one before");
    }
    begin = part.x + part.width;
  }
  if (std::none_of(facts.controls.begin(), facts.controls.end(),
                   [](const ControlFacts& c) { return c.name == kLibraryControl; })) {
    throw InvalidInput("library: the control `" + std::string(kLibraryControl) +
                       "`, which says what a pixel belongs to, is missing");
  }
}

std::size_t History::checked(int index) const {
  if (index >= 0 && index < num_frames()) return static_cast<std::size_t>(index);
  throw InvalidInput("frame " + std::to_string(index) + ": is not in the history; use [0, " +
                     std::to_string(num_frames() - 1) + "]");
}

std::size_t History::control_index(const std::string& name) const {
  std::vector<std::string> names;
  for (const ControlFacts& c : facts().controls) {
    if (c.name == name) return names.size();
    names.push_back(c.name);
  }
  throw InvalidInput(label() + ": has no control `" + name + "`; there " + listed(names) + did_you_mean(name, names));
}

std::vector<double> History::times() const {
  std::vector<double> times;
  for (const FrameFacts& frame : facts().frames) times.push_back(frame.time);
  return times;
}

ImageF History::read_frame(int index) const { return load_frame(checked(index)); }

const ControlFacts& History::control(const std::string& name) const { return facts().controls[control_index(name)]; }

ImageF History::read_control(const std::string& name) const { return load_control(control_index(name)); }

std::optional<ImageF> History::read_control_deviation(const std::string& name) const {
  const std::size_t index = control_index(name);
  if (!facts().controls[index].has_deviation) return std::nullopt;
  return load_control_deviation(index);
}

ImageU8 History::read_mask() const {
  return facts().has_mask ? load_mask() : ImageU8(facts().width, facts().height, 1, 255);
}

ImageF History::read_map(const std::string& name) const {
  const std::vector<std::string>& maps = facts().maps;
  const auto found = std::find(maps.begin(), maps.end(), name);
  if (found == maps.end()) throw InvalidInput(label() + ": has no map `" + name + "`; there " + listed(maps));
  return load_map(static_cast<std::size_t>(found - maps.begin()));
}

std::optional<ImageF> History::read_frame_extra(int index, const std::string& name) const {
  const std::size_t frame = checked(index);
  (void)frame_extra_channels(name);  // There is such a thing.
  const std::vector<std::string>& extras = facts().frames[frame].extras;
  const auto found = std::find(extras.begin(), extras.end(), name);
  if (found == extras.end()) return std::nullopt;
  return load_frame_extra(frame, static_cast<std::size_t>(found - extras.begin()));
}

ImageU8 History::read_frame_mask(int index) const {
  const std::size_t frame = checked(index);
  ImageU8 mask = read_mask();
  if (!facts().frames[frame].has_mask) return mask;
  const ImageU8 own = load_frame_mask(frame);
  const auto to = mask.values();
  const auto from = own.values();
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = std::min(to[i], from[i]);
  return mask;
}

TimePosition History::locate(double time) const {
  if (std::isnan(time)) throw InvalidInput("time: is not a number");
  const auto& frames = facts().frames;
  if (time <= frames.front().time) return {0, 0.0};
  if (time >= frames.back().time) return {num_frames() - 1, 0.0};
  const auto next = std::upper_bound(frames.begin(), frames.end(), time,
                                     [](double t, const FrameFacts& frame) { return t < frame.time; });
  const FrameFacts& before = *(next - 1);
  return {static_cast<int>(next - frames.begin()) - 1, (time - before.time) / (next->time - before.time)};
}

ImageF History::sample(double time) const {
  const TimePosition position = locate(time);
  ImageF image = read_frame(position.index);
  if (position.fraction == 0.0) return image;
  const ImageF next = read_frame(position.index + 1);
  const float fraction = static_cast<float>(position.fraction);
  const auto to = image.values();
  const auto from = next.values();
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = (1.0f - fraction) * to[i] + fraction * from[i];
  return image;
}

}  // namespace patinate
