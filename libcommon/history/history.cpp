#include "libcommon/history/history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "libcommon/core/error.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/core/files.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

/// @throws IoError if the file is no image of the history's size.
void check_file(const fs::path& file, const HistoryManifest& manifest) {
  const ImageInfo info = probe_image(file);
  if (info.width == manifest.width && info.height == manifest.height) return;
  throw IoError(file.string(), "is " + size_text(info.width, info.height) + " pixels; the history says " +
                                   size_text(manifest.width, manifest.height));
}

template <class T>
void check_size(const std::string& what, const Image<T>& image, const HistoryManifest& manifest, int channels) {
  if (image.width() == manifest.width && image.height() == manifest.height && image.channels() == channels) return;
  throw InvalidInput(what + ": is " + size_text(image.width(), image.height()) + " with " +
                     std::to_string(image.channels()) + " channels; expected " +
                     size_text(manifest.width, manifest.height) + " with " + std::to_string(channels));
}

/// @throws InvalidInput if `index` is negative.
std::string numbered(int index, const char* extension) {
  if (index < 0) throw InvalidInput("frame " + std::to_string(index) + ": indices start at 0");
  char name[32];
  std::snprintf(name, sizeof(name), "%04d%s", index, extension);
  return name;
}

constexpr std::array<std::string_view, 4> kMapNames{"position", "normal", "height", "texel_size"};

/// @returns Its place in the order of maps. @throws InvalidInput
std::ptrdiff_t map_order(const std::string& name) {
  const auto* const found = std::find(kMapNames.begin(), kMapNames.end(), name);
  if (found == kMapNames.end()) throw InvalidInput("map `" + name + "`: use position, normal, height or texel_size");
  return found - kMapNames.begin();
}

std::vector<std::string> map_channels(const std::string& name) {
  return map_order(name) < 2 ? std::vector<std::string>{"X", "Y", "Z"} : std::vector<std::string>{"Y"};
}

/// @returns Its place among kFrameExtraNames. @throws InvalidInput
std::ptrdiff_t extra_order(const std::string& name) {
  const auto* const found = std::find(kFrameExtraNames.begin(), kFrameExtraNames.end(), name);
  if (found == kFrameExtraNames.end()) throw InvalidInput("`" + name + "` of a frame: use stddev, specular, normal or height");
  return found - kFrameExtraNames.begin();
}

std::vector<std::string> extra_channels(const std::string& name) {
  static const std::array<std::vector<std::string>, 4> kChannels{{{"R", "G", "B"}, {"strength", "roughness"}, {"X", "Y", "Z"}, {"Y"}}};
  return kChannels[static_cast<std::size_t>(extra_order(name))];
}

void check_texel_size(const HistoryManifest& manifest) {
  if (manifest.texel_size_mm && !(*manifest.texel_size_mm >= kLeastTexel_mm && *manifest.texel_size_mm <= kLargestTexel_mm)) {
    throw InvalidInput("history " + manifest.name + ": texel_size_mm must be within 1e-9 and 1e9");
  }
}

void make_parent(const fs::path& file) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) throw CannotComplete(file.parent_path().string() + ": cannot be made; " + error.message());
}

}  // namespace

HistoryReader::HistoryReader(const fs::path& path) {
  std::error_code error;
  folder_ = fs::is_directory(path, error) ? path : manifest_folder(path, path.filename().string());
  manifest_ = read_history_manifest(path);
  for (const HistoryFrame& frame : manifest_.frames) {
    check_file(folder_ / frame.file, manifest_);
    if (frame.mask) check_file(folder_ / *frame.mask, manifest_);
  }
  for (const ControlParameter& control : manifest_.controls) check_file(folder_ / control.file, manifest_);
  if (manifest_.mask) check_file(folder_ / *manifest_.mask, manifest_);
}

void HistoryReader::check_index(int index) const {
  if (index >= 0 && index < num_frames()) return;
  throw InvalidInput("frame " + std::to_string(index) + ": is not in the history; use [0, " + std::to_string(num_frames() - 1) +
                     "]");
}

ImageF HistoryReader::read_frame(int index) const {
  check_index(index);
  const fs::path file = folder_ / manifest_.frames[static_cast<std::size_t>(index)].file;
  ImageF frame = read_color(file);
  if (frame.width() != manifest_.width || frame.height() != manifest_.height) check_file(file, manifest_);
  return frame;
}

const ControlParameter& HistoryReader::control(const std::string& name) const {
  std::vector<std::string> names;
  std::string list;
  for (const ControlParameter& c : manifest_.controls) {
    if (c.name == name) return c;
    names.push_back(c.name);
    list += (list.empty() ? "" : ", ") + c.name;
  }
  throw InvalidInput(folder_.string() + ": has no control `" + name + "`; there " +
                     (list.empty() ? "are none" : "is: " + list) + did_you_mean(name, names));
}

ImageF HistoryReader::read_control(const std::string& name) const {
  const fs::path file = folder_ / control(name).file;
  ImageF values = read_gray(file);
  if (values.width() != manifest_.width || values.height() != manifest_.height) check_file(file, manifest_);
  for (float v : values.values()) {
    if (!(v >= 0.0f && v <= 1.0f)) {
      throw IoError(file.string(), "holds " + number_text(static_cast<double>(v)) +
                                       "; a control is normalised to [0, 1], with `range` for its physical values");
    }
  }
  return values;
}

ImageU8 HistoryReader::read_mask() const {
  if (!manifest_.mask) return ImageU8(manifest_.width, manifest_.height, 1, 255);
  const fs::path file = folder_ / *manifest_.mask;
  ImageU8 mask = patinate::read_mask(file);
  if (mask.width() != manifest_.width || mask.height() != manifest_.height) check_file(file, manifest_);
  const auto values = mask.values();
  if (std::all_of(values.begin(), values.end(), [](std::uint8_t v) { return v == 0; })) {
    throw IoError(file.string(), "is 0 everywhere; a mask must leave something inside (255)");
  }
  return mask;
}

ImageF HistoryReader::read_map(const std::string& name) const {
  std::string list;
  for (const HistoryMap& map : manifest_.maps) {
    if (map.name == name) {
      check_file(folder_ / map.file, manifest_);
      return read_channels(folder_ / map.file, map_channels(name));
    }
    list += (list.empty() ? "" : ", ") + map.name;
  }
  throw InvalidInput(folder_.string() + ": has no map `" + name + "`; there " + (list.empty() ? "are none" : "is: " + list));
}

std::optional<ImageF> HistoryReader::read_frame_extra(int index, const std::string& name) const {
  check_index(index);
  const std::vector<std::string> channels = extra_channels(name);
  for (const HistoryImage& extra : manifest_.frames[static_cast<std::size_t>(index)].extras) {
    if (extra.name != name) continue;
    check_file(folder_ / extra.file, manifest_);
    return read_channels(folder_ / extra.file, channels);
  }
  return std::nullopt;
}

ImageU8 HistoryReader::read_frame_mask(int index) const {
  check_index(index);
  ImageU8 mask = read_mask();
  const auto& own = manifest_.frames[static_cast<std::size_t>(index)].mask;
  if (!own) return mask;
  const ImageU8 frame_mask = patinate::read_mask(folder_ / *own);
  if (frame_mask.width() != mask.width() || frame_mask.height() != mask.height()) check_file(folder_ / *own, manifest_);
  const auto to = mask.values();
  const auto from = frame_mask.values();
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = std::min(to[i], from[i]);
  return mask;
}

TimePosition HistoryReader::locate(double time) const {
  if (std::isnan(time)) throw InvalidInput("time: is not a number");
  const auto& frames = manifest_.frames;
  if (time <= frames.front().time) return {0, 0.0};
  if (time >= frames.back().time) return {num_frames() - 1, 0.0};
  const auto next = std::upper_bound(frames.begin(), frames.end(), time,
                                     [](double t, const HistoryFrame& frame) { return t < frame.time; });
  const HistoryFrame& before = *(next - 1);
  return {static_cast<int>(next - frames.begin()) - 1, (time - before.time) / (next->time - before.time)};
}

ImageF HistoryReader::sample(double time) const {
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

HistoryWriter::HistoryWriter(fs::path folder, HistoryManifest manifest)
    : folder_(std::move(folder)), manifest_(std::move(manifest)) {
  constexpr int kMaxSide = 65536;
  if (manifest_.width < 1 || manifest_.height < 1 || manifest_.width > kMaxSide || manifest_.height > kMaxSide) {
    throw InvalidInput("history " + manifest_.name + ": a size of " + size_text(manifest_.width, manifest_.height) +
                       " is out of range; use 1 to 65536");
  }
  if (manifest_.origin != "captured" && manifest_.origin != "simulated" && manifest_.origin != "synthetic") {
    throw InvalidInput("history " + manifest_.name + ": unknown origin `" + manifest_.origin +
                       "`; use captured, simulated or synthetic");
  }
  check_texel_size(manifest_);
}

fs::path HistoryWriter::frame_file(int index) { return fs::path("frames") / numbered(index, ".exr"); }

fs::path HistoryWriter::frame_mask_file(int index) { return fs::path("masks") / numbered(index, ".png"); }

fs::path HistoryWriter::filled_frame_file(int index) { return fs::path("filled") / numbered(index, ".exr"); }

fs::path HistoryWriter::control_file(const std::string& name) {
  require_file_name("control", name);
  return fs::path("controls") / (name + ".exr");
}

void HistoryWriter::write_control(const std::string& name, const ImageF& values, double low, double high,
                                  const std::string& unit) {
  check_size("control " + name, values, manifest_, 1);
  if (!(low <= high) || !std::isfinite(low) || !std::isfinite(high)) {
    throw InvalidInput("control " + name + ": its range [" + number_text(low) + ", " + number_text(high) +
                       "] must be finite with low <= high");
  }
  ImageF normalised(values.width(), values.height());
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double value = static_cast<double>(values.values()[k]);
    if (!std::isfinite(value)) throw InvalidInput("control " + name + ": holds NaN or infinite values");
    if (low < high) normalised.values()[k] = static_cast<float>(std::clamp((value - low) / (high - low), 0.0, 1.0));
  }
  const fs::path file = control_file(name);
  make_parent(folder_ / file);
  write_exr(folder_ / file, normalised, {"Y"}, ExrDepth::Float);
  add_written_control({.name = name, .file = file, .low = low, .high = high, .unit = unit});
}

void HistoryWriter::add_written_control(const ControlParameter& control) {
  manifest_.controls.push_back(control);
  manifest_.controls.back().file = control_file(control.name);
}

void HistoryWriter::write_frame(int index, double time, const ImageF& rgb) {
  check_size(frame_file(index).string(), rgb, manifest_, 3);
  make_parent(folder_ / frame_file(index));
  write_exr(folder_ / frame_file(index), rgb, {"R", "G", "B"}, ExrDepth::Half);
  add_written_frame(index, time);
}

void HistoryWriter::add_written_frame(int index, double time) {
  manifest_.frames.push_back({.time = time, .file = frame_file(index)});
}

HistoryFrame& HistoryWriter::named_frame(int index) {
  const fs::path file = frame_file(index), filled = filled_frame_file(index);
  const auto frame = std::find_if(manifest_.frames.begin(), manifest_.frames.end(),
                                  [&](const HistoryFrame& f) { return f.file == file || f.file == filled; });
  if (frame == manifest_.frames.end()) throw InvalidInput(file.string() + ": is no frame of the history yet");
  return *frame;
}

void HistoryWriter::add_written_frame_mask(int index) { named_frame(index).mask = frame_mask_file(index); }

fs::path HistoryWriter::frame_extra_file(int index, const std::string& name) {
  (void)extra_order(name);
  return fs::path(name) / numbered(index, ".exr");
}

void HistoryWriter::write_frame_extra(const fs::path& folder, int index, const std::string& name, const ImageF& values) {
  const std::vector<std::string> channels = extra_channels(name);
  if (values.channels() != static_cast<int>(channels.size())) {
    throw InvalidInput("`" + name + "` of a frame: has " + std::to_string(values.channels()) + " channels; expected " + std::to_string(channels.size()));
  }
  make_parent(folder / frame_extra_file(index, name));
  write_exr(folder / frame_extra_file(index, name), values, channels, ExrDepth::Float);
}

void HistoryWriter::add_written_frame_extra(int index, const std::string& name) {
  auto& extras = named_frame(index).extras;
  const auto place = std::find_if(extras.begin(), extras.end(), [&](const HistoryImage& e) { return extra_order(e.name) >= extra_order(name); });
  if (place != extras.end() && place->name == name) throw InvalidInput("`" + name + "` of a frame: is given twice");
  extras.insert(place, {name, frame_extra_file(index, name)});
}

void HistoryWriter::add_filled_frame(int index) { named_frame(index).file = filled_frame_file(index); }

void HistoryWriter::write_mask(const ImageU8& mask) {
  check_size("mask", mask, manifest_, 1);
  ImageU8 codes(mask.width(), mask.height());
  bool is_empty = true;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      codes.at(x, y) = mask.at(x, y) != 0 ? 255 : 0;
      is_empty = is_empty && mask.at(x, y) == 0;
    }
  }
  if (is_empty) throw InvalidInput("mask: is 0 everywhere; a mask must leave something inside (255)");
  make_parent(folder_ / mask_file());
  write_codes(folder_ / mask_file(), codes);
  add_written_mask();
}

void HistoryWriter::add_written_mask() { manifest_.mask = mask_file(); }

fs::path HistoryWriter::map_file(const std::string& name) {
  (void)map_order(name);
  return fs::path("maps") / (name + ".exr");
}

void HistoryWriter::write_map(const fs::path& folder, const std::string& name, const ImageF& values) {
  const std::vector<std::string> channels = map_channels(name);
  if (values.channels() != static_cast<int>(channels.size())) {
    throw InvalidInput("map " + name + ": has " + std::to_string(values.channels()) + " channels; expected " + std::to_string(channels.size()));
  }
  make_parent(folder / map_file(name));
  write_exr(folder / map_file(name), values, channels, ExrDepth::Float);
}

void HistoryWriter::add_written_map(const std::string& name) {
  auto& maps = manifest_.maps;
  const auto place = std::find_if(maps.begin(), maps.end(), [&](const HistoryMap& m) { return map_order(m.name) >= map_order(name); });
  if (place != maps.end() && place->name == name) throw InvalidInput("map " + name + ": is given twice");
  maps.insert(place, {name, map_file(name)});
}

void HistoryWriter::set_texel_size_mm(double size) {
  manifest_.texel_size_mm = size;
  check_texel_size(manifest_);
}

void HistoryWriter::finish() {
  std::stable_sort(manifest_.frames.begin(), manifest_.frames.end(),
                   [](const HistoryFrame& a, const HistoryFrame& b) { return a.time < b.time; });
  write_history_manifest(folder_ / kHistoryManifestFile, manifest_);
}

}  // namespace patinate
