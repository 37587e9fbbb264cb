#include "patinate/history/history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/footprint.h"
#include "libcommon/history/material_range.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

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
  return zero_padded(static_cast<std::uint64_t>(index), 4) + extension;
}

/// @returns Its place in the order of maps. @throws InvalidInput
std::ptrdiff_t map_order(const std::string& name) {
  (void)history_map_channels(name);
  return std::find(kHistoryMapNames.begin(), kHistoryMapNames.end(), name) - kHistoryMapNames.begin();
}

/// @returns Its place among kFrameExtraNames. @throws InvalidInput
std::ptrdiff_t extra_order(const std::string& name) {
  (void)frame_extra_channels(name);
  return std::find(kFrameExtraNames.begin(), kFrameExtraNames.end(), name) - kFrameExtraNames.begin();
}

/// Decoded, and of another size than the file said before.
template <class T>
Image<T> fitting(Image<T> image, const fs::path& file, const HistoryManifest& manifest) {
  if (image.width() != manifest.width || image.height() != manifest.height) check_file(file, manifest);
  return image;
}

void check_texel_size(const HistoryManifest& manifest) {
  if (manifest.texel_size_mm &&
      !(*manifest.texel_size_mm >= kMinTexel_mm && *manifest.texel_size_mm <= kLargestTexel_mm)) {
    throw InvalidInput("history " + manifest.name + ": texel_size_mm must be within 1e-9 and 1e9");
  }
}

void make_parent(const fs::path& file) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) throw CannotComplete(file.parent_path().string() + ": cannot be made; " + error.message());
}

}  // namespace

HistoryReader::HistoryReader(const fs::path& path, double footprint_px) : footprint_px_(footprint_px) {
  std::error_code error;
  folder_ = fs::is_directory(path, error) ? path : manifest_folder(path, path.filename().string());
  label_ = folder_.string();
  manifest_ = read_history_manifest(path);
  facts_ = facts_of(manifest_);
  for (const HistoryFrame& frame : manifest_.frames) {
    check_file(folder_ / frame.file, manifest_);
    if (frame.mask) check_file(folder_ / *frame.mask, manifest_);
  }
  for (const ControlParameter& control : manifest_.controls) {
    check_file(folder_ / control.file, manifest_);
    if (control.deviation) check_file(folder_ / *control.deviation, manifest_);
  }
  if (manifest_.mask) check_file(folder_ / *manifest_.mask, manifest_);
}

ImageF HistoryReader::load_frame(std::size_t frame) const {
  const fs::path file = folder_ / manifest_.frames[frame].file;
  ImageF color = fitting(read_color(file), file, manifest_);
  if (footprint_px_ <= kMinFootprint_px) return color;
  return mean_over_footprint(std::move(color), manifest_.mask ? load_mask() : ImageU8(), footprint_px_);
}

ImageF HistoryReader::load_control(std::size_t control) const {
  const fs::path file = folder_ / manifest_.controls[control].file;
  ImageF values = fitting(read_gray(file), file, manifest_);
  for (float v : values.values()) {
    if (!(v >= 0.0f && v <= 1.0f)) {
      throw IoError(file.string(), "holds " + number_text(static_cast<double>(v)) +
                                       "; a control is normalized to [0, 1], with `range` for its physical values");
    }
  }
  return values;
}

ImageF HistoryReader::load_control_deviation(std::size_t control) const {
  const fs::path file = folder_ / *manifest_.controls[control].deviation;
  ImageF values = fitting(read_gray(file), file, manifest_);
  for (float v : values.values()) {
    if (!(v >= 0.0f)) throw IoError(file.string(), "holds a standard deviation below 0");
  }
  return values;
}

ImageU8 HistoryReader::load_mask() const {
  const fs::path file = folder_ / *manifest_.mask;
  ImageU8 mask = fitting(patinate::read_mask(file), file, manifest_);
  const auto values = mask.values();
  if (std::all_of(values.begin(), values.end(), [](std::uint8_t v) { return v == 0; })) {
    throw IoError(file.string(), "is 0 everywhere; a mask must leave something inside (255)");
  }
  return mask;
}

ImageF HistoryReader::load_map(std::size_t map) const {
  const HistoryMap& known = manifest_.maps[map];
  check_file(folder_ / known.file, manifest_);
  ImageF values = checked_material(known, read_channels(folder_ / known.file, history_map_channels(known.name)));
  // Geometry stays as it is; what light meets is the mean, as of frames.
  if (!is_material_map(known.name)) return values;
  return mean_extra_over_footprint(known.name, std::move(values), footprint_px_);
}

ImageF HistoryReader::load_frame_extra(std::size_t frame, std::size_t extra) const {
  const HistoryImage& known = manifest_.frames[frame].extras[extra];
  check_file(folder_ / known.file, manifest_);
  ImageF values = checked_material(known, read_channels(folder_ / known.file, frame_extra_channels(known.name)));
  return mean_extra_over_footprint(known.name, std::move(values), footprint_px_);
}

ImageF HistoryReader::checked_material(const HistoryImage& image, ImageF values) const {
  if (const auto problem = find_material_problem(image.name, values))
    throw IoError((folder_ / image.file).string(), *problem);
  return values;
}

ImageU8 HistoryReader::load_frame_mask(std::size_t frame) const {
  const fs::path file = folder_ / *manifest_.frames[frame].mask;
  return fitting(patinate::read_mask(file), file, manifest_);
}

HistoryWriter::HistoryWriter(fs::path folder, HistoryManifest manifest)
    : folder_(std::move(folder)), manifest_(std::move(manifest)) {
  if (manifest_.width < 1 || manifest_.height < 1 || manifest_.width > kMaxHistorySide_px ||
      manifest_.height > kMaxHistorySide_px) {
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
  ImageF normalized(values.width(), values.height());
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double value = static_cast<double>(values.values()[k]);
    if (!std::isfinite(value)) throw InvalidInput("control " + name + ": holds NaN or infinite values");
    if (low < high) normalized.values()[k] = static_cast<float>(std::clamp((value - low) / (high - low), 0.0, 1.0));
  }
  const fs::path file = control_file(name);
  make_parent(folder_ / file);
  write_scaled_exr(folder_ / file, normalized, {low, high, unit});
  add_written_control({.name = name, .file = file, .low = low, .high = high, .unit = unit});
}

fs::path HistoryWriter::control_deviation_file(const std::string& name) {
  require_file_name("control", name);
  return fs::path("controls") / (name + ".stddev.exr");
}

void HistoryWriter::write_control_deviation(const ImageF& values) {
  if (manifest_.controls.empty()) throw InvalidInput("deviation of a control: there is no control yet");
  ControlParameter& control = manifest_.controls.back();
  check_size("deviation of control " + control.name, values, manifest_, 1);
  const double span = control.high - control.low;
  ImageF scaled(values.width(), values.height());
  for (std::int64_t i = 0; i < values.num_pixels(); ++i) {
    const double value = static_cast<double>(values.data()[i]);
    if (!std::isfinite(value) || value < 0.0)
      throw InvalidInput("deviation of control " + control.name + ": must be finite and not below 0");
    if (span > 0.0) scaled.data()[i] = static_cast<float>(value / span);
  }
  const fs::path file = control_deviation_file(control.name);
  write_scaled_exr(folder_ / file, scaled, {0.0, span, control.unit});
  control.deviation = file;
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

void HistoryWriter::write_frame_extra(const fs::path& folder, int index, const std::string& name,
                                      const ImageF& values) {
  const std::vector<std::string>& channels = frame_extra_channels(name);
  if (values.channels() != static_cast<int>(channels.size())) {
    throw InvalidInput("`" + name + "` of a frame: has " + std::to_string(values.channels()) + " channels; expected " +
                       std::to_string(channels.size()));
  }
  make_parent(folder / frame_extra_file(index, name));
  write_exr(folder / frame_extra_file(index, name), values, channels, ExrDepth::Float);
}

void HistoryWriter::add_written_frame_extra(int index, const std::string& name) {
  auto& extras = named_frame(index).extras;
  const auto place = std::find_if(extras.begin(), extras.end(),
                                  [&](const HistoryImage& e) { return extra_order(e.name) >= extra_order(name); });
  if (place != extras.end() && place->name == name) throw InvalidInput("`" + name + "` of a frame: is given twice");
  extras.insert(place, {name, frame_extra_file(index, name)});
}

fs::path HistoryWriter::frame_amounts_file(int index) { return fs::path("amounts") / numbered(index, ".exr"); }

void HistoryWriter::write_frame_amounts(const fs::path& folder, int index, const std::vector<std::string>& materials,
                                        const ImageF& values) {
  if (values.channels() != static_cast<int>(materials.size()))
    throw InvalidInput("amounts of a frame: expected a channel for each material");
  make_parent(folder / frame_amounts_file(index));
  write_exr(folder / frame_amounts_file(index), values, materials, ExrDepth::Float);
}

void HistoryWriter::add_written_frame_amounts(int index) { named_frame(index).amounts = frame_amounts_file(index); }

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
  const std::vector<std::string>& channels = history_map_channels(name);
  if (values.channels() != static_cast<int>(channels.size())) {
    throw InvalidInput("map " + name + ": has " + std::to_string(values.channels()) + " channels; expected " +
                       std::to_string(channels.size()));
  }
  make_parent(folder / map_file(name));
  write_exr(folder / map_file(name), values, channels, ExrDepth::Float);
}

void HistoryWriter::add_written_map(const std::string& name) {
  auto& maps = manifest_.maps;
  const auto place =
      std::find_if(maps.begin(), maps.end(), [&](const HistoryMap& m) { return map_order(m.name) >= map_order(name); });
  if (place != maps.end() && place->name == name) throw InvalidInput("map " + name + ": is given twice");
  maps.insert(place, {name, map_file(name)});
}

void HistoryWriter::set_texel_size_mm(double size) {
  manifest_.texel_size_mm = size;
  check_texel_size(manifest_);
}

void HistoryWriter::add_warning(HistoryWarning warning) { manifest_.warnings.push_back(std::move(warning)); }

void HistoryWriter::finish() {
  sort_warnings(manifest_.warnings);
  std::stable_sort(manifest_.frames.begin(), manifest_.frames.end(),
                   [](const HistoryFrame& a, const HistoryFrame& b) { return a.time < b.time; });
  write_history_manifest(folder_ / kHistoryManifestFile, manifest_);
}

}  // namespace patinate
