#include "capture/ingest/capture_project.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/ingest/frame_times.h"
#include "libcommon/core/error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/json.h"
#include "libcommon/core/text.h"
#include "libcommon/image/image_io.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxFrames = 1'000'000;

/// Photographs in order; times are given, or to be found.
struct FrameList {
  std::vector<fs::path> photos;
  std::vector<double> times;  ///< Empty: to be found.
  std::string source;
};

/// start + i * interval as a person would write it: 25 * 19.4 is 485, not 484.99999999999994.
double time_at(double start, double interval, std::size_t i) {
  constexpr int kDigits = 12;
  constexpr double kNear = 1e-6;  // In intervals: far more than rounding, far less than a frame.
  const double time = start + rounded(static_cast<double>(i) * interval, kDigits);
  const double plain = rounded(time, kDigits);
  return std::abs(plain - time) <= kNear * interval ? plain : time;
}

FrameList read_pattern(JsonReader json) {
  const fs::path pattern = json.member("pattern").path();
  FrameList list;
  list.photos = list_files(pattern.parent_path(), pattern.filename().string());
  if (list.photos.empty()) json.member("pattern").fail("a pattern that matches files; " + pattern.string() + " matches none");
  if (json.has("interval")) {
    const double interval = json.member("interval").number(above(0));
    const double start = json.has("start") ? json.member("start").number() : 0.0;
    for (std::size_t i = 0; i < list.photos.size(); ++i) {
      const double time = time_at(start, interval, i);
      const bool is_later = list.times.empty() || list.times.back() < time;
      if (!is_later || !std::isfinite(time)) {
        json.member("interval")
            .fail("an interval by which the times of " + std::to_string(list.photos.size()) + " frames from " +
                  number_text(start) + " on can differ");
      }
      list.times.push_back(time);
    }
    list.source = "interval";
  } else if (json.has("start")) {
    json.member("start").fail("no `start` without `interval`");
  }
  json.finish();
  return list;
}

FrameList read_list(const JsonReader& json) {
  FrameList list;
  std::size_t num_timed = 0;
  for (JsonReader& entry : json.elements(kMaxFrames)) {
    list.photos.push_back(entry.member("photo").path());
    if (entry.has("time")) {
      const JsonReader time = entry.member("time");
      const double value = time.number();
      if (!list.times.empty() && !(list.times.back() < value)) {
        time.fail("a time later than that of the frame before (" + number_text(list.times.back()) + ")");
      }
      list.times.push_back(value);
      ++num_timed;
    }
    entry.finish();
    if (num_timed != 0 && num_timed != list.photos.size()) entry.fail("a `time` for every frame, or for none");
  }
  if (list.photos.empty()) json.fail("at least one frame");
  list.source = "list";
  return list;
}

/// Indices of the frames that are kept.
std::vector<std::size_t> kept_frames(JsonReader& json, std::size_t num_frames) {
  std::set<std::int64_t> excluded;
  if (json.has("exclude")) {
    for (const JsonReader& index : json.member("exclude").elements(kMaxFrames)) {
      excluded.insert(index.integer(between(0, static_cast<double>(num_frames) - 1)));
    }
  }
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < num_frames; ++i) {
    if (!excluded.contains(static_cast<std::int64_t>(i))) kept.push_back(i);
  }
  if (kept.empty()) json.member("exclude").fail("at least one frame left");
  return kept;
}

/// Probes the photographs, finds missing times, and fills project.frames in order of time.
void resolve_frames(FrameList list, JsonReader& json, CaptureProject& project) {
  std::vector<fs::path> photos;
  std::vector<double> times;
  for (std::size_t i : kept_frames(json, list.photos.size())) {
    photos.push_back(std::move(list.photos[i]));
    if (!list.times.empty()) times.push_back(list.times[i]);
  }
  std::vector<std::string> dates;
  std::vector<bool> has_alpha;
  for (const fs::path& photo : photos) {
    const ImageInfo info = probe_image(photo);
    if (info.num_frames != 1) {
      throw IoError(photo.string(), "holds " + std::to_string(info.num_frames) + " images; give one file for each photograph");
    }
    if (dates.empty()) {
      project.photo_width = info.width;
      project.photo_height = info.height;
    } else if (info.width != project.photo_width || info.height != project.photo_height) {
      throw IoError(photo.string(), "is " + size_text(info.width, info.height) + " pixels, but " +
                                        photos.front().filename().string() + " is " +
                                        size_text(project.photo_width, project.photo_height) +
                                        "; all photographs must have one size");
    }
    dates.push_back(info.date_time);
    has_alpha.push_back(std::find(info.channels.begin(), info.channels.end(), "A") != info.channels.end());
  }
  project.time_source = list.source;
  if (times.empty()) {
    try {
      FrameTimes found = find_frame_times(photos, dates, project.time_unit);
      times = std::move(found.times);
      project.time_source = found.source;
    } catch (const InvalidInput& e) {
      throw IoError(json.file(), e.what());
    }
  }
  for (std::size_t i = 0; i < photos.size(); ++i) project.frames.push_back({times[i], photos[i], has_alpha[i]});
  std::stable_sort(project.frames.begin(), project.frames.end(),
                   [](const CapturePhoto& a, const CapturePhoto& b) { return a.time < b.time; });
}

Response read_response(JsonReader json) {
  Response response;
  if (json.is_object()) {
    response.kind = Response::Kind::Gamma;
    response.gamma = json.member("gamma").number({0, 10, true});
    json.finish();
    return response;
  }
  constexpr std::array<std::string_view, 2> kNames{"srgb", "linear"};
  if (!json.is_string()) json.fail("\"srgb\", \"linear\" or {\"gamma\": 2.2}");
  response.kind = json.choice(kNames) == 0 ? Response::Kind::Srgb : Response::Kind::Linear;
  return response;
}

/// A map in register with the photographs. @throws IoError
void check_map_size(const fs::path& file, const CaptureProject& project, bool may_be_history_size) {
  const ImageInfo info = probe_image(file);
  if (info.width == project.photo_width && info.height == project.photo_height) return;
  if (may_be_history_size && info.width == project.width() && info.height == project.height()) return;
  throw IoError(file.string(), "is " + size_text(info.width, info.height) + " pixels; expected " +
                                   size_text(project.photo_width, project.photo_height) + ", as the frames");
}

TransmissionPhotos read_transmission(JsonReader json, const CaptureProject& project) {
  TransmissionPhotos transmission;
  transmission.photo = json.member("photo").path();
  if (json.has("blank")) transmission.blank = json.member("blank").path();
  if (json.has("align")) {
    const JsonReader align = json.member("align");
    if (!align.is_string() || align.string() != "none") {
      align.fail("\"none\"; aligning a transmission photograph is not yet supported, so take it from the frames' camera pose");
    }
  }
  json.finish();
  check_map_size(transmission.photo, project, false);
  if (transmission.blank) check_map_size(*transmission.blank, project, false);
  return transmission;
}

std::vector<GivenControl> read_controls(const JsonReader& json, const CaptureProject& project) {
  std::vector<GivenControl> controls;
  std::set<std::string> names;
  if (project.transmission) names.insert("thickness");
  for (JsonReader& entry : json.elements(1000)) {
    GivenControl control;
    const JsonReader name = entry.member("name");
    control.name = name.string();
    try {
      (void)HistoryWriter::control_file(control.name);
    } catch (const InvalidInput&) {
      name.fail("a name of letters, digits, dots, `_` and `-`");
    }
    if (!names.insert(control.name).second) name.fail("a name that no other control has");
    control.file = entry.member("file").path();
    if (entry.has("unit")) control.unit = entry.member("unit").string();
    entry.finish();
    check_map_size(control.file, project, true);
    controls.push_back(std::move(control));
  }
  return controls;
}

void read_geometry(JsonReader& json, CaptureProject& project) {
  project.roi = {0, 0, project.photo_width, project.photo_height};
  if (json.has("roi")) {
    const JsonReader roi = json.member("roi");
    const std::vector<double> numbers = roi.numbers(4, between(0, 65536));
    const auto is_whole = [](double v) { return v == std::floor(v); };
    if (!std::all_of(numbers.begin(), numbers.end(), is_whole)) roi.fail("four whole numbers of pixels");
    const auto pixel = [&](std::size_t i) { return static_cast<int>(numbers[i]); };
    project.roi = {pixel(0), pixel(1), pixel(2), pixel(3)};
    if (project.roi.width < 1 || project.roi.height < 1 || project.roi.x + project.roi.width > project.photo_width ||
        project.roi.y + project.roi.height > project.photo_height) {
      roi.fail("[x, y, width, height] inside the photographs of " + size_text(project.photo_width, project.photo_height));
    }
  }
  if (json.has("scale")) project.scale = json.member("scale").number({0, 1, true});
  if (json.has("texel_size_mm")) {
    const JsonReader size = json.member("texel_size_mm");
    if (!size.is_null()) project.texel_size_mm = size.number(above(0));
  }
}

}  // namespace

int CaptureProject::width() const { return std::max(1, static_cast<int>(std::lround(roi.width * scale))); }
int CaptureProject::height() const { return std::max(1, static_cast<int>(std::lround(roi.height * scale))); }

CaptureProject read_capture_project(const fs::path& file) {
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  json.expect_format("patinate.capture", 1);
  constexpr std::array<std::string_view, 2> kKinds{"fixed", "relit"};
  const JsonReader kind = json.member("kind");
  if (kKinds[static_cast<std::size_t>(kind.choice(kKinds))] == "relit") {
    kind.fail("\"fixed\"; relit captures (a scan and one photograph per light) are not in this version");
  }
  CaptureProject project;
  project.file = file;
  project.name = json.member("name").string();
  constexpr std::array<std::string_view, 4> kTimeUnits{"s", "min", "h", "d"};
  if (json.has("time_unit")) project.time_unit = static_cast<TimeUnit>(json.member("time_unit").choice(kTimeUnits));
  if (json.has("response")) project.response = read_response(json.member("response"));
  const JsonReader frames = json.member("frames");
  if (!frames.is_array() && !frames.is_object()) frames.fail("a list of frames, or {\"pattern\": ...}");
  FrameList list = frames.is_array() ? read_list(frames) : read_pattern(frames);
  resolve_frames(std::move(list), json, project);
  read_geometry(json, project);
  if (json.has("transmission")) project.transmission = read_transmission(json.member("transmission"), project);
  if (json.has("controls")) project.controls = read_controls(json.member("controls"), project);
  if (json.has("mask")) {
    project.mask = json.member("mask").path();
    check_map_size(*project.mask, project, true);
  }
  if (json.has("scan")) json.member("scan").fail("no `scan`; geometry under a fixed camera is not in this version");
  json.finish();
  return project;
}

}  // namespace patinate
