#include "capture/project/capture_project.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/background/background.h"
#include "capture/project/capture_text.h"
#include "capture/project/given_transforms.h"
#include "capture/project/sample_facts.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/appearance_json.h"
#include "libcommon/image/response_io.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/geometry/camera_io.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// A map in register with the photographs. @throws IoError
void check_map_size(const fs::path& file, const CaptureProject& project, bool may_be_history_size) {
  const ImageInfo info = probe_image(file);
  if (info.width == project.photo_width && info.height == project.photo_height) return;
  if (may_be_history_size && info.width == project.width() && info.height == project.height()) return;
  throw IoError(file.string(), "is " + size_text(info.width, info.height) + " pixels; expected " +
                                   size_text(project.photo_width, project.photo_height) + ", as the frames");
}

/// "none", "auto", or [[[x, y] in the photograph, [x, y] in the frames], ...].
void read_align(const JsonReader& json, TransmissionPhotos& transmission) {
  if (json.is_array()) {
    constexpr std::size_t kMaxPairs = 1000;
    for (const JsonReader& pair : json.elements(kMaxPairs)) {
      const std::vector<JsonReader> ends = pair.elements(kMaxPairs);
      if (ends.size() != 2) pair.fail("[[x, y] in the transmission photograph, [x, y] in the frames]");
      const std::vector<double> from = ends[0].numbers(2, between(-65536, 65536)),
                                to = ends[1].numbers(2, between(-65536, 65536));
      transmission.points.push_back({{from[0], from[1]}, {to[0], to[1]}});
    }
    transmission.align = TransmissionPhotos::Align::Points;
    try {
      (void)align_points(transmission.points);
    } catch (const InvalidInput&) {
      json.fail("four or more pairs of points, no three of them on a line");
    }
    return;
  }
  if (!json.is_string()) json.fail("\"none\", \"auto\" or four pairs of points");
  constexpr std::array<std::string_view, 2> kNames{"none", "auto"};
  transmission.align = static_cast<TransmissionPhotos::Align>(json.choice(kNames));
}

TransmissionPhotos read_transmission(JsonReader json, const CaptureProject& project) {
  TransmissionPhotos transmission;
  transmission.photo = json.member("photo").path();
  if (json.has("blank")) transmission.blank = json.member("blank").path();
  if (json.has("align")) read_align(json.member("align"), transmission);
  json.finish();
  if (transmission.align == TransmissionPhotos::Align::None) {
    check_map_size(transmission.photo, project, false);
    if (transmission.blank) check_map_size(*transmission.blank, project, false);
    return transmission;
  }
  const ImageInfo photo = probe_image(transmission.photo);
  const ImageInfo blank = transmission.blank ? probe_image(*transmission.blank) : photo;
  if (blank.width != photo.width || blank.height != photo.height) {
    throw IoError(transmission.blank->string(), "is " + size_text(blank.width, blank.height) + " pixels; expected " +
                                                    size_text(photo.width, photo.height) +
                                                    ", as the transmission photograph");
  }
  return transmission;
}

/// @param unit  Where `unit` of the project stands; nothing when it is not given.
ScanSource read_scan(JsonReader json, const std::optional<JsonReader>& unit, const CaptureProject& project) {
  if (!unit)
    throw IoError(project.file.string(),
                  "has a `scan` but no `unit`; expected the length unit of mesh and camera: um, mm, cm or m");
  const double mm = kMmPerLengthUnit[unit->choice(kLengthUnitNames)];
  const std::filesystem::path mesh = json.member("mesh").path();
  const JsonReader where = json.member("camera");
  const Camera camera = read_camera(where, mm);
  json.finish();
  std::error_code error;
  if (!fs::exists(mesh, error)) throw IoError(mesh.string(), "is not there; `scan` names it as its mesh");
  const CameraParameters& p = camera.parameters();
  if (p.width != project.photo_width || p.height != project.photo_height) {
    where.fail("a camera of the photographs, " + size_text(project.photo_width, project.photo_height) +
               " pixels; this one takes " + size_text(p.width, p.height));
  }
  return {.mesh = mesh, .mm_per_unit = mm, .camera_mm = camera};
}

std::vector<GivenControl> read_controls(const JsonReader& json, const CaptureProject& project) {
  std::vector<GivenControl> controls;
  std::set<std::string> names;
  if (project.transmission) names.insert("thickness");
  if (project.scan) names.insert("accessibility");
  for (JsonReader& entry : json.elements(1000)) {
    GivenControl control;
    const JsonReader name = entry.member("name");
    control.name = name.string();
    if (!is_file_name(control.name)) name.fail("a name of " + file_name_text());
    if (!names.insert(control.name).second) name.fail("a name that no other control has");
    control.file = entry.member("file").path();
    if (entry.has("unit")) control.unit = entry.member("unit").string();
    entry.finish();
    check_map_size(control.file, project, true);
    controls.push_back(std::move(control));
  }
  return controls;
}

/// [x, y, width, height] inside of the photographs.
PixelRectangle read_rectangle(const JsonReader& json, const CaptureProject& project) {
  const std::vector<double> numbers = json.numbers(4, between(0, 65536));
  const auto is_whole = [](double v) { return v == std::floor(v); };
  if (!std::all_of(numbers.begin(), numbers.end(), is_whole)) json.fail("four whole numbers of pixels");
  const auto pixel = [&](std::size_t i) { return static_cast<int>(numbers[i]); };
  const PixelRectangle part{pixel(0), pixel(1), pixel(2), pixel(3)};
  if (part.width < 1 || part.height < 1 || part.x + part.width > project.photo_width ||
      part.y + part.height > project.photo_height) {
    json.fail("[x, y, width, height] inside the photographs of " +
              size_text(project.photo_width, project.photo_height));
  }
  return part;
}

void read_geometry(JsonReader& json, CaptureProject& project) {
  project.roi = {0, 0, project.photo_width, project.photo_height};
  if (json.has("roi")) project.roi = read_rectangle(json.member("roi"), project);
  if (json.has("reference_patch")) project.reference_patch = read_rectangle(json.member("reference_patch"), project);
  if (json.has("scale")) project.scale = json.member("scale").number({0, 1, true});
  if (json.has("texel_size_mm")) {
    const JsonReader size = json.member("texel_size_mm");
    if (!size.is_null()) project.texel_size_mm = size.number(between(kMinTexel_mm, kLargestTexel_mm));
  }
}

/// Reads the reference and transforms of an earlier run, and checks that sizes are equal where they must be.
void read_reference(CaptureProject& project) {
  if (project.align.transforms) read_transforms(*project.align.transforms, project);
  // The one in the middle has most in common with all others.
  if (project.align.method != AlignMethod::Off) project.reference = static_cast<int>(project.frames.size() / 2);
  if (!project.align.to.empty()) project.reference = find_photo(project, project.align.to, "`align_to`");
  const CapturePhoto& reference = project.frames[project.reference];
  project.photo_width = reference.width;
  project.photo_height = reference.height;
  const bool is_aligned = project.align.method != AlignMethod::Off;
  for (const CapturePhoto& photo : project.frames) {
    if (is_aligned || photo.transform) continue;
    if (photo.width == reference.width && photo.height == reference.height) continue;
    throw IoError(photo.file.string(), "is " + size_text(photo.width, photo.height) + " pixels, but " +
                                           reference.file.filename().string() + " is " +
                                           size_text(reference.width, reference.height) +
                                           "; all photographs must have one size, or be aligned with each other "
                                           "(--align auto)");
  }
}

}  // namespace

int CaptureProject::width() const { return std::max(1, static_cast<int>(std::lround(roi.width * scale))); }
int CaptureProject::height() const { return std::max(1, static_cast<int>(std::lround(roi.height * scale))); }

bool CaptureProject::is_handheld() const {
  return align.method != AlignMethod::Off ||
         std::any_of(frames.begin(), frames.end(), [](const CapturePhoto& p) { return p.transform.has_value(); });
}

CaptureProject read_capture_project(const fs::path& file, const AlignOptions& align, const ChartOptions& chart) {
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  json.expect_format("patinate.capture", 1);
  const JsonReader kind = json.member("kind");
  if (kCaptureKinds[kind.choice(kCaptureKinds)] != "fixed") kind.fail("\"fixed\"");
  CaptureProject project;
  project.file = file;
  project.name = json.member("name").string();
  project.sample = read_sample(json);
  constexpr std::array<std::string_view, 4> kTimeUnits{"s", "min", "h", "d"};
  if (json.has("time_unit")) project.time_unit = static_cast<TimeUnit>(json.member("time_unit").choice(kTimeUnits));
  if (json.has("response")) project.response = read_response(json.member("response"));
  FrameSources sources = read_frame_sources(json, project.time_unit);
  project.frames = std::move(sources.photos);
  project.excluded = std::move(sources.excluded);
  project.time_source = std::move(sources.time_source);
  project.time_span = std::move(sources.time_span);
  project.time_warnings = std::move(sources.time_warnings);
  project.has_raw_frames = sources.is_raw;
  project.align = read_align_settings(json, align);
  read_reference(project);
  read_geometry(json, project);
  project.chart = read_chart_settings(json, chart, sources.num_images, project.frames);
  if (json.has("transmission")) project.transmission = read_transmission(json.member("transmission"), project);
  const std::optional<JsonReader> unit = json.has("unit") ? std::optional(json.member("unit")) : std::nullopt;
  if (unit) (void)unit->choice(kLengthUnitNames);
  if (json.has("scan")) project.scan = read_scan(json.member("scan"), unit, project);
  project.rig = read_capture_rig(json, unit, project);
  if (json.has("controls")) project.controls = read_controls(json.member("controls"), project);
  if (json.has("mask")) {
    project.mask = json.member("mask").path();
    check_map_size(*project.mask, project, true);
  }
  if (json.has("background")) {
    const JsonReader background = json.member("background");
    project.background = background.string();
    try {
      (void)background_rule(project.background);
    } catch (const InvalidInput&) {
      background.fail(std::string(kBackgroundRules));
    }
  }
  if (json.has("appearance")) {
    project.appearance = read_appearance(json.member("appearance"));
    for (const auto* value :
         {&project.appearance.metalness, &project.appearance.roughness, &project.appearance.specular}) {
      if (*value && (*value)->by == StatedValue::By::Mask) check_map_size((*value)->mask, project, true);
    }
  }
  json.finish();
  return project;
}

std::filesystem::path capture_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error) ? path / "capture.json" : path;
}

}  // namespace patinate::capture
