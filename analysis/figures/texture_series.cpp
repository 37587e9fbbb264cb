#include "patinate/analysis/texture_series.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/footprint.h"
#include "libcommon/image/between_pixels.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history_sampling.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTransferFile = "transfer.json";
constexpr std::size_t kMostTiles = 1000;

bool is_transfer(const fs::path& path) {
  std::error_code error;
  return path.filename() == kTransferFile || fs::is_regular_file(path / kTransferFile, error);
}

/// The folder of the history that a path means: itself, or what a transfer names.
fs::path history_of(const fs::path& path) {
  if (!is_transfer(path)) return path;
  const fs::path file = manifest_folder(path, kTransferFile) / kTransferFile;
  const Json json = load_json(file);
  JsonReader reader(file.string(), json);
  reader.expect_format("patinate.transfer", 1);
  return reader.member("history").member("path").path().lexically_normal();
}

/// Tiles below one another.
ImageF stacked(const std::vector<ImageF>& tiles) {
  if (tiles.size() == 1) return tiles.front();
  ImageF out(tiles.front().width(), tiles.front().height() * static_cast<int>(tiles.size()), 2);
  float* to = out.data();
  for (const ImageF& tile : tiles) to = std::copy(tile.values().begin(), tile.values().end(), to);
  return out;
}

/// "points outside ..." of the first coordinate that does.
std::optional<std::string> find_outside(const ImageF& coordinates, const HistoryFacts& history) {
  for (std::int64_t i = 0; i < coordinates.num_pixels(); ++i) {
    const float x = coordinates.data()[2 * i], y = coordinates.data()[2 * i + 1];
    const bool is_outside = x == -1.0f && y == -1.0f;
    if (is_outside || (x >= 0.0f && y >= 0.0f && x <= static_cast<float>(history.width - 1) &&
                       y <= static_cast<float>(history.height - 1)))
      continue;
    return "points outside its history at " + number_text(static_cast<double>(x)) + "," +
           number_text(static_cast<double>(y));
  }
  return std::nullopt;
}

/// Pixels that a texel shows the mean of. @throws IoError
double read_footprint(const fs::path& transfer) {
  const fs::path file = manifest_folder(transfer, kTransferFile) / kTransferFile;
  const Json json = load_json(file);
  JsonReader reader(file.string(), json);
  return reader.has("footprint_px") ? reader.member("footprint_px").number(between(1, kLargestFootprint_px)) : 1.0;
}

/// @throws IoError; InvalidInput if it looks into a history of another size.
SeriesAtlas read_atlas(const fs::path& transfer, const HistoryReader& history) {
  const HistoryFacts& facts = history.facts();
  const fs::path file = manifest_folder(transfer, kTransferFile) / kTransferFile;
  const Json json = load_json(file);
  JsonReader reader(file.string(), json);
  reader.expect_format("patinate.transfer", 1);
  const int width = static_cast<int>(reader.member("width").integer(between(1, 65536)));
  const int height = static_cast<int>(reader.member("height").integer(between(1, 65536)));
  JsonReader source = reader.member("history");
  if (source.member("width").integer() != facts.width || source.member("height").integer() != facts.height) {
    throw InvalidInput(file.string() + ": looks into a history of " + std::to_string(source.member("width").integer()) +
                       " x " + std::to_string(source.member("height").integer()) + " pixels; " + history.label() +
                       " has " + size_text(facts.width, facts.height));
  }
  std::vector<fs::path> files;
  if (reader.has("coordinates")) {
    files.push_back(reader.member("coordinates").path());
  } else {
    for (JsonReader& tile : reader.member("tiles").elements(kMostTiles))
      files.push_back(tile.member("coordinates").path());
  }
  std::vector<ImageF> tiles;
  for (const fs::path& f : files) {
    tiles.push_back(read_channels(f, {"source.x", "source.y"}));
    if (tiles.back().width() != width || tiles.back().height() != height)
      throw IoError(f.string(), "has another size than transfer.json says");
    if (const auto problem = find_outside(tiles.back(), facts)) throw IoError(f.string(), *problem);
  }
  if (tiles.empty()) throw IoError(file.string(), "names no coordinates");
  SeriesAtlas atlas{.name = reader.has("mesh") ? reader.member("mesh").member("made_from").string() : "an atlas",
                    .coordinates = stacked(tiles),
                    .texel_mm = {}};
  if (reader.has("texel_size_mm"))
    atlas.texel_mm = reader.member("texel_size_mm").number(between(kMinTexel_mm, kLargestTexel_mm));
  return atlas;
}

}  // namespace

TextureSeries::TextureSeries(std::shared_ptr<const History> history)
    : history_(std::move(history)), name_(facts().name), pixel_mm_(facts().texel_size_mm) {}

TextureSeries::TextureSeries(std::shared_ptr<const History> history, SeriesAtlas atlas)
    : history_(std::move(history)),
      name_(facts().name + " on " + atlas.name),
      pixel_mm_(atlas.texel_mm),
      coordinates_(std::move(atlas.coordinates)) {
  if (coordinates_.empty() || coordinates_.channels() != 2)
    throw InvalidInput(name_ + ": expected two coordinates a texel");
  if (const auto problem = find_outside(coordinates_, facts())) throw InvalidInput(name_ + ": " + *problem);
}

int TextureSeries::width() const { return coordinates_.empty() ? facts().width : coordinates_.width(); }
int TextureSeries::height() const { return coordinates_.empty() ? facts().height : coordinates_.height(); }

ImageU8 TextureSeries::looked_up(ImageU8 codes) const {
  if (coordinates_.empty()) return codes;
  ImageU8 out(width(), height(), codes.channels());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      if (coordinates_.at(x, y, 0) < 0.0f) continue;
      const NearestPixel at = nearest_pixel(coordinates_.at(x, y, 0), coordinates_.at(x, y, 1));
      const auto from = codes.pixel(at.x, at.y);
      std::copy(from.begin(), from.end(), out.pixel(x, y).begin());
    }
  }
  return out;
}

ImageF TextureSeries::looked_up(ImageF values) const {
  return coordinates_.empty() ? values : look_up(values, coordinates_);
}

ImageU8 TextureSeries::mask(double time) const {
  const TimePosition at = history_->locate(time);
  ImageU8 mask = history_->read_frame_mask(at.index);
  if (at.fraction > 0.0) {
    const ImageU8 next = history_->read_frame_mask(at.index + 1);
    for (std::int64_t i = 0; i < mask.num_pixels(); ++i) mask.data()[i] &= next.data()[i];
  }
  return looked_up(std::move(mask));
}

ImageF TextureSeries::sample(double time) const { return looked_up(history_->sample(time)); }
bool TextureSeries::has_deviation() const {
  return std::all_of(facts().frames.begin(), facts().frames.end(), [](const FrameFacts& f) {
    return std::find(f.extras.begin(), f.extras.end(), "stddev") != f.extras.end();
  });
}

ImageF TextureSeries::deviation(double time) const {
  const double inside = std::clamp(time, facts().frames.front().time, facts().frames.back().time);
  return looked_up(sample_material_map(*history_, MaterialMap::Stddev, inside, Between::Blend));
}

ImageF TextureSeries::control(const std::string& name) const { return looked_up(history_->read_control(name)); }

SeriesFile open_series(const fs::path& path, const fs::path& through) {
  const fs::path transfer = through.empty() && is_transfer(path) ? path : through;
  const auto history =
      std::make_shared<const HistoryReader>(history_of(path), transfer.empty() ? 1.0 : read_footprint(transfer));
  if (!is_transfer(path) && through.empty()) return {history, TextureSeries(history)};
  if (is_transfer(path) && !through.empty())
    throw InvalidInput(path.string() +
                       ": is a transfer, which is looked up through its own coordinates; --through is for a history");
  return {history, TextureSeries(history, read_atlas(through.empty() ? path : through, *history))};
}

std::string SeriesFile::key() const {
  ContentHash hash;
  const HistoryManifest& m = history->manifest();
  const fs::path& folder = history->folder();
  if (!m.key.empty()) {
    hash.add(m.key);
  } else {
    hash.add_file(folder / kHistoryManifestFile);
    for (const HistoryFrame& frame : m.frames) {
      hash.add_file(folder / frame.file);
      if (frame.mask) hash.add_file(folder / *frame.mask);
    }
    for (const ControlParameter& control : m.controls) hash.add_file(folder / control.file);
    if (m.mask) hash.add_file(folder / *m.mask);
  }
  hash.add(std::int64_t{series.coordinates().width()}).add(std::as_bytes(series.coordinates().values()));
  return hash.hex();
}

}  // namespace patinate::analysis
