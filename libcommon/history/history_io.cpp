#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libcommon/core/text.h"
#include "libcommon/document/document.h"
#include "libcommon/geometry/length_unit.h"
#include "libcommon/history/history_documents.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history.h"

namespace patinate {

namespace {

constexpr std::size_t kMaxFrames = 1'000'000;
constexpr std::size_t kMaxControls = 1'000;

/// Images by their names, in the order of `names`. @param helps  As many as names.
template <std::size_t N>
void describe_images(DocumentVisitor& v, std::vector<HistoryImage>& images,
                     const std::array<std::string_view, N>& names, const std::array<std::string_view, N>& helps) {
  for (std::size_t i = 0; i < N; ++i) {
    const auto found =
        std::find_if(images.begin(), images.end(), [&](const HistoryImage& m) { return m.name == names[i]; });
    std::optional<std::filesystem::path> file;
    if (found != images.end()) file = found->file;
    v.member(if_set(names[i], helps[i]), file);
    if (v.is_reading() && file) images.push_back({std::string(names[i]), *file});
  }
}

constexpr std::array<std::string_view, kFrameExtraNames.size()> kFrameExtraHelps{
    "Standard deviation of the albedo.",
    "EXR, channels strength and roughness.",
    "Normals.",
    "Height.",
    "EXR, channel Y, [0, 1]: 1 = metal. All frames have it, or none.",
    "EXR, R, G, B, linear, [0, 1]: color of the mirror; of metal what it reflects at normal incidence; 0 = not known. "
    "All frames have it, or none."};
constexpr std::array<std::string_view, kHistoryMapNames.size()> kMapHelps{
    "Position of each pixel's surface point.",
    "Normals.",
    "Height.",
    "Surface length of each pixel.",
    "Channels strength and roughness, where frames have none.",
    "As frames have it, where they have none.",
    "As frames have it, where they have none."};

constexpr DocumentKind kHistoryDocument{
    .format = "patinate.history",
    .title = "patinate material history",
    .about = "history.json: the color of a surface over time, with its control parameters.",
    .has_whole_numbers = true};

}  // namespace

void describe(DocumentVisitor& v, HistoryFrame& f) {
  v.member(
      {"time",
       "In time_unit, between -1e18 and 1e18; later than the time before by 1e-12 at least, and by 1e-12 of the span."},
      f.time);
  v.member({"file", "Linear albedo, half RGB EXR."}, f.file);
  v.member(
      if_set("mask", "8 bit; 0 where this frame's color is not the surface's (highlight, saturated, out of view)."),
      f.mask);
  describe_images(v, f.extras, kFrameExtraNames, kFrameExtraHelps);
  v.member(if_set("amounts", "Of a simulation: EXR, a channel for each material, named after it; 1 = a full layer."),
           f.amounts);
  v.member(if_set("extrapolated", "Nobody saw it: a model continues from where the frames end."), f.is_extrapolated);
}

void describe(DocumentVisitor& v, ControlParameter& c) {
  v.member({.name = "name", .help = "Letters, digits, dots, `_` and `-`; not a dot first.", .rule = &file_name_rule()},
           c.name);
  v.member({"file", "Float EXR, channel Y, normalized to [0, 1]."}, c.file);
  std::array<double, 2> range{c.low, c.high};
  v.member({"range", "Physical values that 0 and 1 stand for.", between(-kLargestControl, kLargestControl),
            Presence::Optional},
           range);
  v.require("range", range[0] <= range[1], "[low, high] with low <= high");
  c.low = range[0], c.high = range[1];
  v.member(if_set("unit", "`relative` when only ratios mean something."), c.unit);
  v.member(if_set("stddev", "Float EXR, channel Y: standard deviation of what `file` holds, in its units."),
           c.deviation);
}

void describe(DocumentVisitor& v, LibraryPart& p) {
  v.member({"name", "Of the history that it was made from."}, p.name);
  v.member({"x", "First column; the first row is 0.", between(0, kMaxHistorySide_px)}, p.x);
  v.member({"width", "px", between(1, kMaxHistorySide_px)}, p.width);
  v.member({"height", "px", between(1, kMaxHistorySide_px)}, p.height);
  v.member({"key", "Content key of the history that it was made from."}, p.key);
}

void describe(DocumentVisitor& v, HistoryWarning& w) {
  v.choice({"about", "What it is about."}, w.about, kWarningSubjectNames);
  v.member({"text", "What was found, with its figure."}, w.text);
  v.member(if_set("cure", "What helps."), w.cure);
  double share = v.is_reading() ? w.share : std::round(1e4 * w.share) / 1e4;
  v.member({"share", "Roughly how much of the history it spoils.", between(0, 1)}, share);
  w.share = share;
  v.member(if_set("photos", "Names of the photographs it speaks of, without folders."), w.photos);
}

void describe(DocumentVisitor& v, SampleFact& s) {
  v.member({"name", "What is said: `coating`."}, s.name);
  v.member({"text", "Its value."}, s.text);
}

void describe(DocumentVisitor& v, HistoryManifest& m) {
  v.member({"name", "For people."}, m.name);
  auto origin = static_cast<int>(std::find(kHistoryOriginNames.begin(), kHistoryOriginNames.end(), m.origin) -
                                 kHistoryOriginNames.begin());
  v.choice({"origin", "Where it comes from."}, origin, kHistoryOriginNames);
  m.origin = kHistoryOriginNames[origin];
  v.member({"width", "Pixels of every image.", between(1, kMaxHistorySide_px)}, m.width);
  v.member({"height", "Pixels of every image.", between(1, kMaxHistorySide_px)}, m.height);
  v.member({.name = "texel_size_mm",
            .help = "Surface length that a pixel shows, mm; null when unknown.",
            .range = between(kMinTexel_mm, kLargestTexel_mm),
            .presence = Presence::Optional,
            .is_nullable = true},
           m.texel_size_mm);
  v.choice({.name = "time_unit", .help = "Unit of all times.", .presence = Presence::Optional}, m.time_unit,
           kTimeUnitNames);
  v.member({.name = "frames", .help = "In order of strictly increasing time.", .min_size = 1, .max_size = kMaxFrames},
           m.frames);
  v.member({.name = "controls",
            .help = "Parameters that aging follows.",
            .presence = Presence::Optional,
            .max_size = kMaxControls},
           m.controls);
  v.member({.name = "mask", .help = "8 bit; 0 = outside.", .presence = Presence::IfSet, .is_nullable = true}, m.mask);
  v.object({.name = "maps", .help = "Constant in time.", .presence = Presence::IfSet}, !m.maps.empty(),
           [&] { describe_images(v, m.maps, kHistoryMapNames, kMapHelps); });
  v.member({.name = "key", .help = "Content key: of all that this was made from.", .presence = Presence::Optional},
           m.key);
  v.member({.name = "library",
            .help = "Several histories side by side, from left to right (`patinate history combine`); the control "
                    "`history` says which one a pixel belongs to.",
            .presence = Presence::IfSet,
            .max_size = kMaxLibraryParts},
           m.parts);
  v.member(if_set("warnings",
                  "What was found while it was made that may make it wrong, the worst first. Programs that use it "
                  "repeat what concerns them."),
           m.warnings);
  v.member({.name = "sample",
            .help = "What reports say of the sample, as `capture.json` states it.",
            .presence = Presence::IfSet,
            .max_size = kMaxSampleFacts},
           m.sample);
}

namespace {

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
  std::vector<HistoryWarning> written = warnings;
  return object_json([&](DocumentVisitor& v) { v.member({"warnings"}, written); })["warnings"];
}

std::string time_unit_text(TimeUnit unit) { return std::string(kTimeUnitNames[static_cast<std::size_t>(unit)]); }

std::string shown_time_unit(TimeUnit unit) { return unit == TimeUnit::Years ? "yr" : time_unit_text(unit); }

TimeUnit parse_time_unit(const std::string& text) {
  if (text == "yr") return TimeUnit::Years;
  const auto it = std::find(kTimeUnitNames.begin(), kTimeUnitNames.end(), text);
  if (it == kTimeUnitNames.end()) throw InvalidInput("time unit: found `" + text + "`; use s, min, h, d or a (years)");
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
                     .warnings = m.warnings,
                     .sample = m.sample};
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
  HistoryManifest m;
  read_document(kHistoryDocument, file, described(m));
  try {
    check_manifest(m);
  } catch (const InvalidInput& e) {
    throw IoError(file.string(), e.what());
  }
  return m;
}

void write_history_manifest(const std::filesystem::path& file, const HistoryManifest& manifest) {
  check_manifest(manifest);
  HistoryManifest written = manifest;
  save_json(file, document_json(kHistoryDocument, described(written)));
}

Json history_schema() { return document_schema(kHistoryDocument, described<HistoryManifest>()); }

}  // namespace patinate
