#include "tools/patinate/commands/surface_reference.h"

#include <algorithm>
#include <cmath>

#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/controls/image_control.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/analysis/texture_series.h"
#include "patinate/core/error.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/commands/reference_picture.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 2> kAgedEndNames{"high", "low"};
constexpr double kMaxStretch = 0.01;  ///< Share of a picture's sides against the atlas'.
constexpr double kMinKnown = 0.01;    ///< Share of the covered texels: less is a mistake.
/// Channels as they stand in the file; the others are made of linear color.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kRawChannels{
    {{"red", "R"}, {"green", "G"}, {"blue", "B"}}};

bool is_history(const fs::path& reference) {
  const app::PathKind kind = app::kind_of(app::history_place(reference));
  return kind == app::PathKind::History || kind == app::PathKind::Transfer;
}

bool has_positions(const History& history) {
  const std::vector<std::string>& maps = history.facts().maps;
  return std::find(maps.begin(), maps.end(), "position") != maps.end();
}

const std::string_view* raw_channel(const std::string& channel) {
  for (const auto& [name, in_file] : kRawChannels) {
    if (name == channel) return &in_file;
  }
  return nullptr;
}

[[noreturn]] void refuse_channel(const std::string& channel, const std::vector<std::string>& more) {
  std::vector<std::string> names{"luminance", "saturation", "red", "green", "blue", "change"};
  names.insert(names.end(), more.begin(), more.end());
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  throw app::UsageError("--channel: found `" + channel + "`; expected one of " + list + did_you_mean(channel, names));
}

ImageF difference(ImageF after, const ImageF& before) {
  for (std::size_t i = 0; i < after.values().size(); ++i) after.values()[i] -= before.values()[i];
  return after;
}

ImageF fitted(const ImageF& image, int width, int height) {
  const bool is_larger = image.width() >= width && image.height() >= height;
  return is_larger ? downscale_area(image, width, height) : resize_bilinear(image, width, height);
}

/// Color, or one raw channel, of images on the tiles of an atlas.
ImageF on_tiles(const fs::path& path, const TexelMap& map, const std::string_view* raw,
                std::vector<std::string>* notes) {
  const Sheet& sheet = map.sheet();
  const std::vector<fs::path> files = tile_map_files(path, sheet.names);
  ImageF laid(map.width(), map.height(), raw != nullptr ? 1 : 3);
  for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
    const fs::path& file = files[files.size() == 1 ? 0 : static_cast<std::size_t>(tile)];
    const ImageF image = raw != nullptr ? read_gray(file, std::string(*raw)) : read_color(file);
    const double stretch = static_cast<double>(image.width()) * sheet.tile_height /
                           (static_cast<double>(image.height()) * sheet.tile_width);
    if (!(std::abs(stretch - 1.0) <= kMaxStretch))
      throw IoError(file.string(), "is " + size_text(image.width(), image.height()) +
                                       ", no picture of the atlas, which is square; for a photograph give --camera");
    if (notes != nullptr && image.width() != sheet.tile_width)
      notes->push_back(file.filename().string() + " is " + size_text(image.width(), image.height()) +
                       ", and is looked at on " + size_text(sheet.tile_width, sheet.tile_height) + " texels");
    paste_tile(laid, sheet, tile, fitted(image, sheet.tile_width, sheet.tile_height));
  }
  return laid;
}

/// Values of one picture: of a file, whichever way it is read.
template <class ReadColor, class ReadRaw>
ReferencePicture of_files(const ReferenceOptions& options, const std::string& channel, const fs::path& path,
                          const ReadColor& read_whole, const ReadRaw& read_one) {
  ReferencePicture picture;
  picture.color = read_whole(path);
  const auto same_size = [&](ImageF image) {
    return image.same_size(picture.color) ? std::move(image)
                                          : fitted(image, picture.color.width(), picture.color.height());
  };
  if (channel == "change") {
    if (options.before.empty()) throw app::UsageError("--channel change: needs --before, an image of the same surface");
    picture.values = color_change(same_size(read_whole(options.before)), picture.color);
    return picture;
  }
  const std::string_view* raw = raw_channel(channel);
  if (raw == nullptr && channel != "luminance" && channel != "saturation") refuse_channel(channel, {});
  const auto values_of = [&](const fs::path& file, const ImageF* color) {
    if (raw != nullptr) return read_one(file, raw);
    return color_channel(color != nullptr ? *color : same_size(read_whole(file)), channel);
  };
  picture.values = values_of(path, &picture.color);
  if (!options.before.empty())
    picture.values = difference(std::move(picture.values), same_size(values_of(options.before, nullptr)));
  return picture;
}

ReferencePicture of_series(const analysis::TextureSeries& series, const ReferenceOptions& options,
                           const std::string& channel) {
  const std::vector<double> times = series.history().times();
  const double time = options.time.value_or(times.back());
  if (!(time >= times.front() && time <= times.back()))
    throw app::UsageError("--time: found `" + number_text(time) + "`; the history has " + number_text(times.front()) +
                          " to " + number_text(times.back()));
  if (!options.before.empty()) throw app::UsageError("--before: a history's is its first frame; --channel change");
  ReferencePicture picture{.values = {}, .color = series.sample(time), .mask = series.mask(time)};
  std::vector<std::string> controls;
  for (const ControlFacts& c : series.facts().controls) controls.push_back(c.name);
  if (std::find(controls.begin(), controls.end(), channel) != controls.end()) {
    picture.values = series.control(channel);
  } else if (channel == "change") {
    picture.values = color_change(series.sample(times.front()), picture.color);
    const ImageU8 first = series.mask(times.front());
    for (std::int64_t i = 0; i < first.num_pixels(); ++i) picture.mask.data()[i] &= first.data()[i];
  } else if (raw_channel(channel) != nullptr) {
    const auto c = static_cast<int>(std::string_view("RGB").find(*raw_channel(channel)));
    picture.values = ImageF(picture.color.width(), picture.color.height());
    for (int y = 0; y < picture.values.height(); ++y) {
      for (int x = 0; x < picture.values.width(); ++x) picture.values.at(x, y) = picture.color.at(x, y, c);
    }
  } else if (channel == "luminance" || channel == "saturation") {
    picture.values = color_channel(picture.color, channel);
  } else {
    refuse_channel(channel, controls);
  }
  return picture;
}

/// The reference on the atlas.
analysis::SurfaceReference placed(const ReferencePicture& picture, const PixelOfTexel& pixels, const TexelMap& map) {
  analysis::SurfaceReference out{.values = ImageF(map.width(), map.height()),
                                 .mask = ImageU8(map.width(), map.height()),
                                 .color = ImageF(map.width(), map.height(), 3, 0.2F)};
  for (std::size_t t = 0; t < pixels.size(); ++t) {
    if (pixels[t] < 0) continue;
    const auto p = static_cast<std::size_t>(pixels[t]);
    if (!picture.mask.empty() && picture.mask.values()[p] == 0) continue;
    out.values.values()[t] = picture.values.values()[p];
    out.mask.values()[t] = 255;
    std::copy_n(picture.color.values().begin() + static_cast<std::ptrdiff_t>(3 * p), 3,
                out.color.values().begin() + static_cast<std::ptrdiff_t>(3 * t));
  }
  return out;
}

void apply_mask(analysis::SurfaceReference& reference, const fs::path& mask, const TexelMap& map) {
  const Sheet& sheet = map.sheet();
  const std::vector<fs::path> files = tile_map_files(mask, sheet.names);
  for (int tile = 0; tile < sheet.num_tiles(); ++tile) {
    const ImageU8 given = read_mask(files[files.size() == 1 ? 0 : static_cast<std::size_t>(tile)]);
    for (int y = 0; y < sheet.tile_height; ++y) {
      for (int x = 0; x < sheet.tile_width; ++x) {
        const int from_x = static_cast<int>(std::int64_t{x} * given.width() / sheet.tile_width);
        const int from_y = static_cast<int>(std::int64_t{y} * given.height() / sheet.tile_height);
        if (given.at(from_x, from_y) == 0) reference.mask.at(sheet.first_x(tile) + x, sheet.first_y(tile) + y) = 0;
      }
    }
  }
}

double known_share(const ImageU8& mask, const TexelMap& map) {
  std::int64_t known = 0;
  for (TexelId t = 0; t < map.num_texels(); ++t) known += map.is_covered(t) && mask.values()[t] != 0 ? 1 : 0;
  return static_cast<double>(known) / static_cast<double>(std::max<std::int64_t>(1, map.num_covered()));
}

analysis::SurfaceReference of_history(const fs::path& path, const ReferenceOptions& options, const std::string& channel,
                                      const TexelMap& map, ContentHash& hash, const RunControl& control) {
  const analysis::SeriesFile file = analysis::open_series(path);
  hash.add(file.key());
  const ReferencePicture picture = of_series(file.series, options, channel);
  const History& history = file.series.history();
  const bool is_own_atlas = !file.series.coordinates().empty();
  PixelOfTexel pixels;
  if (!is_own_atlas && has_positions(history)) {
    const std::vector<std::string>& maps = history.facts().maps;
    const bool has_normals = std::find(maps.begin(), maps.end(), "normal") != maps.end();
    pixels = pixels_at_positions(map, history.read_map("position"), has_normals ? history.read_map("normal") : ImageF(),
                                 picture.mask, control);
  } else {
    if (!is_own_atlas && history.facts().origin != "simulated")
      throw InvalidInput(path.string() +
                         ": nothing says where on the mesh it lies: it has no `position` map and is no simulation; "
                         "transfer it, or give an image on the mesh's UVs");
    if (map.sheet().num_tiles() != 1 || picture.values.width() != picture.values.height())
      throw InvalidInput(path.string() + ": explained are histories on an atlas of one square");
    pixels = pixels_on_uvs(map, picture.values.width(), picture.values.height());
  }
  analysis::SurfaceReference out = placed(picture, pixels, map);
  const std::vector<HistoryWarning>& warnings = history.facts().warnings;
  if (!warnings.empty()) out.notes.push_back(history_warnings_line(path.string(), warnings));
  return out;
}

std::string about_text(const std::string& name, const std::string& channel, const ReferenceOptions& options,
                       double known) {
  std::string text = channel + " of " + name;
  if (!options.before.empty()) text += " against " + fs::path(options.before).filename().string();
  if (!options.mask.empty()) text += ", inside " + fs::path(options.mask).filename().string();
  text += "; its " + std::string(kAgedEndNames[static_cast<std::size_t>(options.aged)]) + " end counts as aged";
  return text + "; known on " + percent_text(known) + " of the texels";
}

}  // namespace

void describe(OptionVisitor& v, ReferenceOptions& o) {
  v.visit({"channel",
           "Measure of age: luminance, saturation, red, green, blue (as in the file), change (color difference to "
           "--before, or to a history's first frame), or a control of a history; default: change if there is a before, "
           "else luminance"},
          o.channel);
  v.visit({"before", "Image of the same surface when it was new: what is explained is the difference"}, o.before);
  v.visit_choice({"aged", "Which end of the channel counts as aged"}, o.aged, kAgedEndNames);
  v.visit({"mask", "8-bit image on the mesh's UVs; what is 0 there is not looked at"}, o.mask);
  v.visit(
      {"camera", "REFERENCE is a photograph of the mesh: OpenCV calibration with a pose, in the mesh's frame and unit"},
      o.camera);
  v.visit({"time", "Time of a history, in its unit; not given: its last frame"}, o.time);
}

bool lies_on_uvs(const fs::path& reference, const ReferenceOptions& options) {
  if (!is_history(reference)) return options.camera.empty();
  if (app::kind_of(app::history_place(reference)) == app::PathKind::Transfer) return true;
  return !has_positions(HistoryReader(app::history_place(reference)));
}

analysis::SurfaceReference read_surface_reference(const fs::path& path, const ReferenceOptions& options,
                                                  const TexelMap& map, double mm, const RunControl& control) {
  const bool is_series = is_history(path);
  std::string channel = options.channel;
  if (channel.empty()) channel = is_series || !options.before.empty() ? "change" : "luminance";
  ContentHash hash;
  hash.add(channel).add(options.time.value_or(-1.0)).add(std::int64_t{static_cast<int>(options.aged)});
  analysis::SurfaceReference out;
  std::vector<std::string> notes;
  if (is_series) {
    if (!options.camera.empty()) throw app::UsageError("--camera: is for photographs; " + path.string() + " is none");
    out = of_history(app::history_place(path), options, channel, map, hash, control);
  } else if (!options.camera.empty()) {
    const Camera camera = read_camera(fs::path(options.camera)).scaled(mm);
    const ReferencePicture picture = of_files(
        options, channel, path, [](const fs::path& f) { return read_color(f); },
        [](const fs::path& f, const std::string_view* raw) { return read_gray(f, std::string(*raw)); });
    const int width = camera.parameters().width, height = camera.parameters().height;
    if (picture.color.width() != width || picture.color.height() != height)
      throw IoError(path.string(), "is " + size_text(picture.color.width(), picture.color.height()) + ", " +
                                       options.camera + " is of " + size_text(width, height));
    hash.add(camera.text());
    out = placed(picture, pixels_in_view(map, camera, control), map);
  } else {
    const ReferencePicture picture = of_files(
        options, channel, path, [&](const fs::path& f) { return on_tiles(f, map, nullptr, &notes); },
        [&](const fs::path& f, const std::string_view* raw) { return on_tiles(f, map, raw, nullptr); });
    out = placed(picture, pixels_on_uvs(map, map.width(), map.height()), map);
  }
  for (const fs::path& file : {is_series ? fs::path() : path, fs::path(options.before), fs::path(options.mask)}) {
    hash.add(file.empty() ? "" : "file");
    if (file.empty()) continue;
    for (const fs::path& f : tile_map_files(file, map.sheet().names)) hash.add_file(f);
  }
  const double known = known_share(out.mask, map);
  out.name = path.lexically_normal().filename().string();
  if (out.name.empty()) out.name = path.lexically_normal().parent_path().filename().string();
  if (!(known >= kMinKnown))
    throw InvalidInput(path.string() + ": shows " + percent_text(known) +
                       " of the mesh; are both in the same frame and unit, or of the same UVs?");
  if (!options.mask.empty()) apply_mask(out, options.mask, map);
  if (options.aged == AgedEnd::Low) {
    for (float& v : out.values.values()) v = -v;
  }
  out.about = about_text(out.name, channel, options, known_share(out.mask, map));
  out.key = hash.hex();
  out.notes.insert(out.notes.begin(), notes.begin(), notes.end());
  return out;
}

}  // namespace patinate::cli
