#include "capture/timelapse/ingest.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/project/capture_project.h"
#include "capture/stability/frame_noise.h"
#include "capture/timelapse/align_step.h"
#include "capture/timelapse/align_warnings.h"
#include "capture/timelapse/background_step.h"
#include "capture/timelapse/chart_step.h"
#include "capture/timelapse/gloss_step.h"
#include "capture/timelapse/ingest_report.h"
#include "capture/timelapse/ingest_warnings.h"
#include "capture/timelapse/ingest_work.h"
#include "capture/timelapse/mask_warnings.h"
#include "capture/timelapse/patch_step.h"
#include "capture/timelapse/repair_steps.h"
#include "capture/timelapse/scan_step.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/history/stated_history.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// Pixels that are clipped in all photographs, one way.
struct ClippedSeries {
  std::int64_t num_clipped = 0, num_pixels = 0;
  std::vector<std::string> photos;

  void add(std::int64_t clipped, std::int64_t pixels, const CapturePhoto& photo) {
    num_clipped += clipped;
    num_pixels += pixels;
    if (clipped > 0) photos.push_back(photo.name());
  }
  [[nodiscard]] double share() const {
    return static_cast<double>(num_clipped) / static_cast<double>(std::max<std::int64_t>(1, num_pixels));
  }
  [[nodiscard]] std::string count_text() const {
    return std::to_string(num_clipped) + (num_clipped == 1 ? " pixel" : " pixels") + " of " + photos.front() +
           (photos.size() == 1 ? "" : " and " + std::to_string(photos.size() - 1) + " more photographs");
  }
};

/// @param folder  Of the history, whose frames are finished.
std::vector<HistoryWarning> clipping_warnings(const CaptureProject& project, const std::filesystem::path& folder) {
  ClippedSeries outside, beyond;
  for (std::size_t i = 0; i < project.frames.size(); ++i) {
    const CapturePhoto& photo = project.frames[i];
    if (!may_be_clipped(project, photo)) continue;
    const Json json = load_json(folder / clipped_file(static_cast<int>(i)));
    const auto count = [&](const char* name) { return json.at(name).get<std::int64_t>(); };
    outside.add(count("outside"), count("pixels"), photo);
    beyond.add(count("beyond"), count("pixels"), photo);
  }
  std::vector<HistoryWarning> warnings;
  if (outside.num_clipped > 0) {
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "the colors of " + outside.count_text() + " (" + fixed_percent_text(outside.share()) +
                                ") lie outside of Rec. 709; their negative values were set to 0",
                        .cure = "",
                        .share = outside.share(),
                        .photos = outside.photos});
  }
  if (beyond.num_clipped > 0) {
    warnings.push_back({.about = WarningSubject::Light,
                        .text = "the light of " + beyond.count_text() +
                                " exceeds 65504, the largest half float; it was set to that, and counts as saturated",
                        .cure = "",
                        .share = beyond.share(),
                        .photos = beyond.photos});
  }
  return warnings;
}

/// Takes what the transmission photograph does not show off the mask: there is no thickness to guide by.
void keep_reached(const ImageU8& reached, const CaptureProject& project, ImageU8& mask) {
  if (mask.empty()) mask = ImageU8(project.width(), project.height(), 1, 255);
  bool is_any_left = false;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (reached.data()[i] == 0) mask.data()[i] = 0;
    is_any_left = is_any_left || mask.data()[i] != 0;
  }
  if (is_any_left) return;
  throw IoError(project.transmission->photo.string(), "shows nothing of what is inside the mask, as it is aligned");
}

void write_deviations(HistoryWriter& writer, const IngestWork& work, const fs::path& folder,
                      const RunControl& control) {
  std::vector<double> times;
  for (const CapturePhoto& frame : work.project.frames) times.push_back(frame.time);
  const auto read_frame = [&](int i) { return read_color(folder / writer.manifest().frames[i].file); };
  const SeriesNoise noise = estimate_noise(times, read_frame, control.part(0.0, 0.5));
  parallel_for(static_cast<std::int64_t>(times.size()), 1, control.part(0.5, 1.0),
               [&](std::int64_t begin, std::int64_t) {
                 const int i = static_cast<int>(begin);
                 const ImageF frame = read_frame(i);
                 ImageF deviation = noise.deviation_of(frame);
                 add_chart_deviation(work, folder, frame, deviation);
                 HistoryWriter::write_frame_extra(folder, i, "stddev", deviation);
               });
  for (int i = 0; i < static_cast<int>(times.size()); ++i) writer.add_written_frame_extra(i, "stddev");
}

void join(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  HistoryWriter writer(folder, work.manifest());
  for (std::size_t i = 0; i < work.project.frames.size(); ++i) {
    writer.add_written_frame(static_cast<int>(i), work.project.frames[i].time);
  }
  ImageU8 given = read_capture_mask(work.project, control.part(0.0, 0.05));
  const TransmissionLight transmission = read_transmission_light(work, folder, control.part(0.05, 0.1));
  if (!transmission.reached.empty()) keep_reached(transmission.reached, work.project, given);
  keep_scanned(work, folder, given);
  for (HistoryWarning& warning : take_background_off(work, folder, given, control.part(0.1, 0.15)))
    writer.add_warning(std::move(warning));
  const std::optional<SeriesGloss> gloss = measure_gloss(work, folder, given, control.part(0.15, 0.2));
  const ImageU8 mask = mask_frames(writer, work, folder, given, gloss ? &*gloss : nullptr, control.part(0.2, 0.35));
  if (!mask.empty()) writer.write_mask(mask);
  if (gloss) {
    for (HistoryWarning& warning : write_gloss(writer, work, folder, *gloss, control.part(0.35, 0.4)))
      writer.add_warning(std::move(warning));
  }
  SeriesLight light;
  light.static_light = take_static_light_out(writer, work, folder, mask, control.part(0.35, 0.4));
  write_scan(writer, work, folder, mask);
  if (work.options.add_deviations) write_deviations(writer, work, folder, control.part(0.4, 0.5));
  light.layer_window = write_ingest_controls(writer, work, transmission, folder, mask,
                                             control.part(work.options.add_deviations ? 0.5 : 0.4, 0.7));
  for (HistoryWarning& warning : clipping_warnings(work.project, folder)) writer.add_warning(std::move(warning));
  const int num_frames = static_cast<int>(work.project.frames.size());
  for (HistoryWarning& warning : survey_warnings(read_survey_report(folder), num_frames, work.project.is_handheld()))
    writer.add_warning(std::move(warning));
  for (HistoryWarning& warning :
       look_at_light(writer, work, folder, mask, given, std::move(light), control.part(0.7, 0.8)))
    writer.add_warning(std::move(warning));
  for (HistoryWarning& warning : report_alignment(work, folder)) writer.add_warning(std::move(warning));
  for (HistoryWarning& warning : report_patch(work, folder)) writer.add_warning(std::move(warning));
  for (HistoryWarning& warning : report_chart(work, folder)) writer.add_warning(std::move(warning));
  for (const HistoryWarning& warning : work.project.time_warnings) writer.add_warning(warning);
  for (HistoryWarning& warning : mask_warnings(given, mask, num_frames)) writer.add_warning(std::move(warning));
  write_ingest_report(writer.manifest(), work, folder, mask, control.part(0.8, 1.0));
  writer.finish();
  if (!work.project.appearance.is_empty()) {
    const auto read_mask = [&](const fs::path& file) { return to_history_size(read_gray(file), work.project, file); };
    state_appearance(folder, work.project.appearance, read_mask, control.part(1.0, 1.0));
  }
  control.report(1.0);
}

/// For progress, core seconds of a frame, measured on photographs of 128, 512 and 1400 pixels a side: of small ones
/// forcing files to the disk takes longest; in the join of large ones masks, filling and controls.
double frame_weight(const CaptureProject& project) { return 0.012 + 3e-7 * project.width() * project.height(); }
double frame_join_weight(const CaptureProject& project) { return 0.012 + 2.3e-7 * project.width() * project.height(); }

JobItem frame_item(const std::shared_ptr<const IngestWork>& work, int index) {
  const fs::path file = HistoryWriter::frame_file(index);
  JobItem item{.name = "frame-" + file.stem().string(),
               .outputs = {file},
               .run = {},
               .key = ingest_frame_key(*work, static_cast<std::size_t>(index)),
               .stage = ingest_stages(*work).frames,
               .weight = frame_weight(work->project),
               .inputs = {photo_name(work->project, work->project.frames[index])}};
  if (has_validity(*work)) item.outputs.push_back(validity_file(index));
  if (may_be_clipped(work->project, work->project.frames[index])) item.outputs.push_back(clipped_file(index));
  if (work->options.repair.flat_field == kFlatFieldOfFirst) item.outputs.push_back(light_share_file(index));
  item.run = [work, index](const fs::path& folder, const RunControl& control) {
    const CapturePhoto& frame = work->project.frames[index];
    HistoryWriter(folder, work->manifest()).write_frame(index, frame.time, develop_frame(*work, index, folder));
    control.report(1.0);
  };
  return item;
}

}  // namespace

void describe(OptionVisitor& v, IngestOptions& o) {
  v.visit({"progress", "Make the `progress` control (how early each pixel ages) also beside measured controls"},
          o.add_progress);
  v.visit({"deviations",
           "Write the standard deviation of every frame's color (`stddev`), from how photographs differ "
           "from those before and after"},
          o.add_deviations);
  describe(v, o.thickness);
  describe(v, o.progress);
  describe(v, o.repair);
  describe(v, o.scan);
  describe(v, o.background);
  describe(v, o.align);
  describe(v, o.chart);
}

PixelSize reduced_size(const CaptureProject& project, int longest) {
  const double factor = std::min(1.0, static_cast<double>(longest) / std::max(project.width(), project.height()));
  const auto side = [factor](int v) { return std::max(1, static_cast<int>(std::lround(v * factor))); };
  return {side(project.width()), side(project.height())};
}

HistoryManifest IngestWork::manifest() const {
  HistoryManifest m;
  m.name = project.name;
  m.sample = project.sample;
  m.origin = "captured";
  m.width = project.width();
  m.height = project.height();
  if (project.texel_size_mm) m.texel_size_mm = *project.texel_size_mm * project.roi.width / project.width();
  m.time_unit = project.time_unit;
  m.key = key;
  return m;
}

JobPlan plan_ingest(const CaptureProject& project, const IngestOptions& options, const fs::path& output) {
  check_ranges(options);
  check_flat_field(options.repair.flat_field);
  auto work = std::make_shared<IngestWork>(IngestWork{project, options, {}, "", options.add_progress});
  std::string& background = work->options.background.mask_background;
  if (background == "project") background = project.background;
  (void)background_rule(background);
  work->repairs = std::make_shared<RepairTables>();
  work->places = std::make_shared<PlaceTable>();
  work->gains = std::make_shared<GainTable>();
  work->colors = std::make_shared<ColorTable>();
  check_handheld_options(*work);
  check_chart(*work);
  const bool is_measured = project.transmission || project.scan || !project.controls.empty();
  if (!is_measured && project.frames.size() > 1) work->has_progress = true;
  const bool is_progress_given = std::any_of(project.controls.begin(), project.controls.end(),
                                             [](const GivenControl& c) { return c.name == kProgressName; });
  if (work->has_progress && is_progress_given) {
    throw InvalidInput(project.file.string() +
                       ": a control `progress` is given and another one asked for; rename the given one");
  }
  if (project.rig && !options.repair.flat_field.empty()) {
    throw InvalidInput(project.file.string() +
                       ": `lights` say how the light falls off; leave --flat-field or `lights` out");
  }
  if (options.add_deviations && project.frames.size() < kMinForNoise) {
    throw InvalidInput(project.file.string() + ": --deviations: " + std::to_string(kMinForNoise) +
                       " photographs or more tell noise from aging; there are " +
                       std::to_string(project.frames.size()));
  }
  load_scan(*work);
  work->photo_keys = ingest_photo_keys(project);
  leave_out_failed(*work, output);
  if (project.chart) {
    for (const CapturePhoto& photo : project.chart->photos) work->chart_photo_keys.push_back(hash_file(photo.file));
  }
  if (work->known_alignment != nullptr) work->photo_keys = ingest_photo_keys(work->project);
  // Names of files have no part in the key: the same photographs elsewhere give the same history.
  JobPlan plan = ingest_inputs(*work).plan(output, kHistoryManifestFile);
  plan.may_grow = true;
  work->key = plan.key;
  add_alignment_item(plan.items, work);
  add_patch_item(plan.items, work);
  add_chart_item(plan.items, work);
  add_scan_item(plan.items, work);
  add_survey_items(plan.items, work);
  for (std::size_t i = 0; i < work->project.frames.size(); ++i)
    plan.items.push_back(frame_item(work, static_cast<int>(i)));
  plan.weight_seconds = 1.0;
  plan.join_weight = frame_join_weight(work->project) * static_cast<double>(work->project.frames.size());
  plan.join = [work](const fs::path& folder, const RunControl& control) { join(*work, folder, control); };
  return plan;
}

}  // namespace patinate::capture
