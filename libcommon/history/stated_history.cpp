#include "libcommon/history/stated_history.h"

#include <algorithm>
#include <utility>

#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

std::vector<const StatedValue*> values_of(const Appearance& appearance) {
  std::vector<const StatedValue*> values;
  for (const auto* value : {&appearance.metalness, &appearance.roughness, &appearance.specular}) {
    if (*value) values.push_back(&**value);
  }
  return values;
}

AppearanceSources read_sources(const History& history, const Appearance& appearance, const MaskReader& read_mask) {
  AppearanceSources sources;
  for (const StatedValue* value : values_of(appearance)) {
    if (value->by == StatedValue::By::Control && !sources.controls.contains(value->control)) {
      const ControlFacts& facts = history.control(value->control);
      ImageF values = history.read_control(value->control);
      for (float& v : values.values())
        v = static_cast<float>(facts.low + static_cast<double>(v) * (facts.high - facts.low));
      sources.controls.emplace(value->control, std::move(values));
    }
    if (value->by == StatedValue::By::Mask && !sources.masks.contains(value->mask))
      sources.masks.emplace(value->mask, read_mask(value->mask));
  }
  return sources;
}

void write_map(const fs::path& file, const std::string& name, const ImageF& values) {
  fs::create_directories(file.parent_path());
  write_exr(file, values, frame_extra_channels(name), ExrDepth::Half);
}

void add_in_order(std::vector<HistoryImage>& images, std::span<const std::string_view> order, const std::string& name,
                  const fs::path& file) {
  const auto place = [&](const std::string& n) { return std::find(order.begin(), order.end(), n) - order.begin(); };
  const auto at =
      std::find_if(images.begin(), images.end(), [&](const HistoryImage& i) { return place(i.name) > place(name); });
  images.insert(at, {name, file});
}

}  // namespace

void check_appearance(const HistoryFacts& history, const Appearance& appearance) {
  for (const std::string& name : appearance.map_names()) {
    const bool in_frames = std::any_of(history.frames.begin(), history.frames.end(), [&](const FrameFacts& f) {
      return std::find(f.extras.begin(), f.extras.end(), name) != f.extras.end();
    });
    if (in_frames || std::find(history.maps.begin(), history.maps.end(), name) != history.maps.end())
      throw InvalidInput("history " + history.name + ": has `" + name + "` already; state what it does not know");
  }
  std::vector<std::string> names;
  for (const ControlFacts& c : history.controls) names.push_back(c.name);
  for (const StatedValue* value : values_of(appearance)) {
    if (value->by != StatedValue::By::Control || std::find(names.begin(), names.end(), value->control) != names.end())
      continue;
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    throw InvalidInput("appearance: history " + history.name + " has no control `" + value->control + "`; there " +
                       (list.empty() ? "are none" : "is: " + list) + did_you_mean(value->control, names));
  }
}

MaskReader mask_reader(const HistoryFacts& history) {
  return [width = history.width, height = history.height](const fs::path& file) {
    ImageF mask = read_gray(file);
    if (mask.width() != width || mask.height() != height)
      throw IoError(file.string(), "is " + size_text(mask.width(), mask.height()) +
                                       " pixels; expected those of the history, " + size_text(width, height));
    return mask;
  };
}

void state_appearance(const fs::path& folder, const Appearance& appearance, const MaskReader& read_mask,
                      const RunControl& control) {
  const HistoryReader history(folder);
  check_appearance(history.facts(), appearance);
  const AppearanceSources sources = read_sources(history, appearance, read_mask);
  const std::vector<std::string> names = appearance.map_names();
  HistoryManifest manifest = history.manifest();
  if (!appearance.has_course()) {
    const AppearanceMaps maps =
        appearance_maps(appearance, sources, manifest.frames.front().time, history.read_frame(0));
    for (const std::string& name : names) {
      write_map(folder / HistoryWriter::map_file(name), name, maps.of(name));
      add_in_order(manifest.maps, kHistoryMapNames, name, HistoryWriter::map_file(name));
    }
  } else {
    parallel_for(history.num_frames(), 1, control, [&](std::int64_t begin, std::int64_t) {
      const int i = static_cast<int>(begin);
      const double time = manifest.frames[i].time;
      const AppearanceMaps maps = appearance_maps(appearance, sources, time, history.read_frame(i));
      for (const std::string& name : names)
        write_map(folder / HistoryWriter::frame_extra_file(i, name), name, maps.of(name));
    });
    for (std::size_t i = 0; i < manifest.frames.size(); ++i) {
      for (const std::string& name : names)
        add_in_order(manifest.frames[i].extras, kFrameExtraNames, name,
                     HistoryWriter::frame_extra_file(static_cast<int>(i), name));
    }
  }
  write_history_manifest(folder / kHistoryManifestFile, manifest);
  control.report(1.0);
}

}  // namespace patinate
