#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/history_times.h"
#include "libcommon/history/warning_json.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"

namespace patinate {

namespace {

constexpr std::array<std::string_view, 5> kTimeUnitNames{"s", "min", "h", "d", "a"};
constexpr std::size_t kMaxFrames = 1'000'000;
constexpr std::size_t kMaxControls = 1'000;

std::filesystem::path relative_file(const JsonReader& json) {
  (void)json.path();  // Rejects what is no path.
  return json.string();
}

HistoryFrame read_frame_entry(JsonReader json) {
  HistoryFrame frame;
  frame.time = json.member("time").number();
  frame.file = relative_file(json.member("file"));
  if (json.has("mask")) frame.mask = relative_file(json.member("mask"));
  for (std::string_view name : kFrameExtraNames) {
    if (json.has(name)) frame.extras.push_back({std::string(name), relative_file(json.member(name))});
  }
  if (json.has("amounts")) frame.amounts = relative_file(json.member("amounts"));
  if (json.has("extrapolated")) frame.is_extrapolated = json.member("extrapolated").boolean();
  json.finish();
  return frame;
}

ControlParameter read_control_entry(JsonReader json) {
  ControlParameter control;
  const JsonReader name = json.member("name");
  control.name = name.string();
  if (!is_file_name(control.name)) name.fail("a name of " + file_name_text());
  control.file = relative_file(json.member("file"));
  if (json.has("range")) {
    const JsonReader range = json.member("range");
    const std::vector<double> ends = range.numbers(2, between(-kLargestControl, kLargestControl));
    if (!(ends[0] <= ends[1])) range.fail("[low, high] with low <= high");
    control.low = ends[0];
    control.high = ends[1];
  }
  if (json.has("unit")) control.unit = json.member("unit").string();
  if (json.has("stddev")) control.deviation = relative_file(json.member("stddev"));
  json.finish();
  return control;
}

LibraryPart read_part_entry(JsonReader json) {
  LibraryPart part;
  part.name = json.member("name").string();
  part.x = static_cast<int>(json.member("x").integer(between(0, kMaxHistorySide_px)));
  part.width = static_cast<int>(json.member("width").integer(between(1, kMaxHistorySide_px)));
  part.height = static_cast<int>(json.member("height").integer(between(1, kMaxHistorySide_px)));
  part.key = json.member("key").string();
  json.finish();
  return part;
}

HistoryWarning read_warning_entry(JsonReader json) {
  HistoryWarning warning;
  warning.about = static_cast<WarningSubject>(json.member("about").choice(kWarningSubjectNames));
  warning.text = json.member("text").string();
  if (json.has("cure")) warning.cure = json.member("cure").string();
  warning.share = json.member("share").number(between(0, 1));
  if (json.has("photos")) {
    for (const JsonReader& photo : json.member("photos").elements(kMaxFrames)) warning.photos.push_back(photo.string());
  }
  json.finish();
  return warning;
}

Json warning_entry(const HistoryWarning& warning) {
  Json entry{{"about", kWarningSubjectNames[static_cast<std::size_t>(warning.about)]}, {"text", warning.text}};
  if (!warning.cure.empty()) entry["cure"] = warning.cure;
  entry["share"] = std::round(1e4 * warning.share) / 1e4;
  if (!warning.photos.empty()) entry["photos"] = warning.photos;
  return entry;
}

/// Whole numbers are written without ".0", as a person would.
Json number_json(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15) return Json(static_cast<std::int64_t>(value));
  return Json(value);
}

void check_manifest(const HistoryManifest& m) {
  if (m.frames.empty()) throw InvalidInput("history " + m.name + ": has no frames; give at least one");
  std::vector<double> times;
  for (const HistoryFrame& frame : m.frames) times.push_back(frame.time);
  if (const auto problem = find_time_problem(times))
    throw InvalidInput(m.frames[problem->index].file.string() + ": " + problem->text);
  std::vector<std::string> names;
  for (const ControlParameter& c : m.controls) names.push_back(c.name);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end()) throw InvalidInput("control " + *twice + ": is given twice; names must differ");
  check_material_maps(facts_of(m));
  check_library_parts(facts_of(m));
}

}  // namespace

Json warnings_json(const std::vector<HistoryWarning>& warnings) {
  Json json = Json::array();
  for (const HistoryWarning& warning : warnings) json.push_back(warning_entry(warning));
  return json;
}

std::string time_unit_text(TimeUnit unit) { return std::string(kTimeUnitNames[static_cast<std::size_t>(unit)]); }

std::string shown_time_unit(TimeUnit unit) { return unit == TimeUnit::Years ? "yr" : time_unit_text(unit); }

TimeUnit parse_time_unit(const std::string& text) {
  if (text == "yr") return TimeUnit::Years;
  const auto it = std::find(kTimeUnitNames.begin(), kTimeUnitNames.end(), text);
  if (it == kTimeUnitNames.end()) throw InvalidInput("time unit: found `" + text + "`; use s, min, h, d or yr");
  return static_cast<TimeUnit>(it - kTimeUnitNames.begin());
}

double seconds_per(TimeUnit unit) {
  constexpr std::array<double, 5> kSeconds{1.0, 60.0, 3600.0, 86400.0, 365.25 * 86400.0};
  return kSeconds[static_cast<std::size_t>(unit)];
}

HistoryFacts facts_of(const HistoryManifest& m) {
  HistoryFacts facts{.name = m.name,
                     .origin = m.origin,
                     .width = m.width,
                     .height = m.height,
                     .texel_size_mm = m.texel_size_mm,
                     .time_unit = m.time_unit,
                     .frames = {},
                     .controls = {},
                     .has_mask = m.mask.has_value(),
                     .maps = {},
                     .parts = m.parts,
                     .warnings = m.warnings};
  for (const HistoryFrame& f : m.frames) {
    FrameFacts frame{
        .time = f.time, .has_mask = f.mask.has_value(), .extras = {}, .is_extrapolated = f.is_extrapolated};
    for (const HistoryImage& extra : f.extras) frame.extras.push_back(extra.name);
    facts.frames.push_back(std::move(frame));
  }
  for (const ControlParameter& c : m.controls)
    facts.controls.push_back(
        {.name = c.name, .low = c.low, .high = c.high, .unit = c.unit, .has_deviation = c.deviation.has_value()});
  for (const HistoryMap& map : m.maps) facts.maps.push_back(map.name);
  return facts;
}

HistoryManifest read_history_manifest(const std::filesystem::path& path) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(path, error);
  const std::filesystem::path file = is_folder ? path / kHistoryManifestFile : path;
  const Json document = load_json(file);
  JsonReader json(file.string(), document);
  json.expect_format("patinate.history", 1);
  HistoryManifest m;
  m.name = json.member("name").string();
  m.origin = kHistoryOriginNames[json.member("origin").choice(kHistoryOriginNames)];
  m.width = static_cast<int>(json.member("width").integer(between(1, kMaxHistorySide_px)));
  m.height = static_cast<int>(json.member("height").integer(between(1, kMaxHistorySide_px)));
  if (json.has("texel_size_mm")) {
    const JsonReader size = json.member("texel_size_mm");
    if (!size.is_null()) m.texel_size_mm = size.number(between(kLeastTexel_mm, kLargestTexel_mm));
  }
  if (json.has("time_unit")) m.time_unit = static_cast<TimeUnit>(json.member("time_unit").choice(kTimeUnitNames));
  const JsonReader frames = json.member("frames");
  for (JsonReader& frame : frames.elements(kMaxFrames)) m.frames.push_back(read_frame_entry(frame));
  if (json.has("controls")) {
    for (JsonReader& c : json.member("controls").elements(kMaxControls)) m.controls.push_back(read_control_entry(c));
  }
  if (json.has("mask") && !json.member("mask").is_null()) m.mask = relative_file(json.member("mask"));
  if (json.has("maps")) {
    JsonReader maps = json.member("maps");
    for (std::string_view name : kHistoryMapNames) {
      if (maps.has(name)) m.maps.push_back({std::string(name), relative_file(maps.member(name))});
    }
    maps.finish();
  }
  if (json.has("library")) {
    for (const JsonReader& part : json.member("library").elements(kMaxLibraryParts))
      m.parts.push_back(read_part_entry(part));
  }
  if (json.has("warnings")) {
    for (const JsonReader& warning : json.member("warnings").elements(kMaxFrames))
      m.warnings.push_back(read_warning_entry(warning));
  }
  if (json.has("key")) m.key = json.member("key").string();
  json.finish();
  try {
    check_manifest(m);
  } catch (const InvalidInput& e) {
    throw IoError(file.string(), e.what());
  }
  return m;
}

void write_history_manifest(const std::filesystem::path& file, const HistoryManifest& manifest) {
  check_manifest(manifest);
  Json json = {{"format", "patinate.history"}, {"version", 1},
               {"name", manifest.name},        {"origin", manifest.origin},
               {"width", manifest.width},      {"height", manifest.height}};
  json["texel_size_mm"] = manifest.texel_size_mm ? number_json(*manifest.texel_size_mm) : Json(nullptr);
  json["time_unit"] = time_unit_text(manifest.time_unit);
  json["frames"] = Json::array();
  for (const HistoryFrame& f : manifest.frames) {
    Json entry = {{"time", number_json(f.time)}, {"file", f.file.generic_string()}};
    if (f.mask) entry["mask"] = f.mask->generic_string();
    for (const HistoryImage& extra : f.extras) entry[extra.name] = extra.file.generic_string();
    if (f.amounts) entry["amounts"] = f.amounts->generic_string();
    if (f.is_extrapolated) entry["extrapolated"] = true;
    json["frames"].push_back(std::move(entry));
  }
  json["controls"] = Json::array();
  for (const ControlParameter& c : manifest.controls) {
    Json entry = {{"name", c.name}, {"file", c.file.generic_string()}};
    entry["range"] = Json::array({number_json(c.low), number_json(c.high)});
    if (!c.unit.empty()) entry["unit"] = c.unit;
    if (c.deviation) entry["stddev"] = c.deviation->generic_string();
    json["controls"].push_back(std::move(entry));
  }
  if (manifest.mask) json["mask"] = manifest.mask->generic_string();
  for (const HistoryMap& map : manifest.maps) json["maps"][map.name] = map.file.generic_string();
  json["key"] = manifest.key;
  for (const LibraryPart& part : manifest.parts) {
    json["library"].push_back(
        {{"name", part.name}, {"x", part.x}, {"width", part.width}, {"height", part.height}, {"key", part.key}});
  }
  if (!manifest.warnings.empty()) json["warnings"] = warnings_json(manifest.warnings);
  save_json(file, json);
}

}  // namespace patinate
