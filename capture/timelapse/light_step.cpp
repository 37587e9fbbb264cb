#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/stability/static_light.h"
#include "capture/timelapse/ingest_warnings.h"
#include "capture/timelapse/light_report.h"
#include "capture/timelapse/patch_step.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxFrames = 12;  ///< That the light is looked for in.

/// Some frames, evenly spread, small.
std::vector<ImageF> small_frames(std::size_t num_frames, const std::function<ImageF(int)>& read_frame,
                                 const PixelSize& size, const RunControl& control) {
  const std::size_t count = std::min(num_frames, kMaxFrames);
  std::vector<ImageF> frames;
  for (std::size_t k = 0; k < count; ++k) {
    control.throw_if_stopped();
    const std::size_t i = count == 1 ? 0 : k * (num_frames - 1) / (count - 1);
    frames.push_back(downscale_area(read_frame(static_cast<int>(i)), size.width, size.height));
  }
  return frames;
}

/// The finished frames, small.
std::vector<ImageF> small_frames(const HistoryManifest& history, const fs::path& folder, const PixelSize& size,
                                 const RunControl& control) {
  const auto read_frame = [&](int i) { return read_color(folder / history.frames[i].file); };
  return small_frames(history.frames.size(), read_frame, size, control);
}

/// Pixels that the mask has all of.
ImageU8 small_mask(const ImageU8& mask, const PixelSize& size) {
  if (mask.empty()) return {};
  ImageF shares(mask.width(), mask.height());
  std::transform(mask.values().begin(), mask.values().end(), shares.values().begin(),
                 [](std::uint8_t v) { return v != 0 ? 1.0f : 0.0f; });
  constexpr float kAll = 0.999f;  // All of a reduced pixel, but for rounding.
  const ImageF low = downscale_area(shares, size.width, size.height);
  ImageU8 result(size.width, size.height);
  std::transform(low.values().begin(), low.values().end(), result.values().begin(),
                 [](float v) { return static_cast<std::uint8_t>(v > kAll ? 255 : 0); });
  return result;
}

Json survey_of_one() {
  return {{"format", "patinate.survey"}, {"version", 2},          {"stabilized", false}, {"deflickered", false},
          {"findings", Json::array()},   {"pairs", Json::array()}};
}

}  // namespace

std::optional<StaticLight> take_static_light_out(HistoryWriter& writer, const IngestWork& work, const fs::path& folder,
                                                 const ImageU8& mask, const RunControl& control) {
  const RepairOptions& options = work.options.repair;
  if (options.static_light == StaticLightRule::Keep || !options.flat_field.empty()) return std::nullopt;
  if (work.project.rig) return std::nullopt;            // It is known.
  if (work.project.is_handheld()) return std::nullopt;  // The lamp stands where it stands, the camera does not.
  const PixelSize size = reduced_size(work.project, kUnevenLightSide);
  const StaticLight light =
      find_static_light(small_frames(writer.manifest(), folder, size, control), small_mask(mask, size));
  if (!light.is_any()) return std::nullopt;
  const auto num_frames = static_cast<std::int64_t>(work.project.frames.size());
  parallel_for(num_frames, 1, control, [&](std::int64_t begin, std::int64_t) {
    const int i = static_cast<int>(begin);
    ImageF frame = read_color(folder / writer.manifest().frames[i].file);
    take_light_out(frame, light);
    fs::create_directories(folder / HistoryWriter::filled_frame_file(i).parent_path());
    write_exr(folder / HistoryWriter::filled_frame_file(i), frame, {"R", "G", "B"}, ExrDepth::Half);
  });
  for (int i = 0; i < static_cast<int>(num_frames); ++i) writer.add_filled_frame(i);
  return light;
}

void refuse_worse_light(const IngestWork& work, const std::function<ImageF(int)>& read_frame, const ImageF& gain,
                        const ImageU8& mask, const RunControl& control) {
  constexpr double kWorse = 1.02;  // Factor of the ratio: what it is rounded to in messages.
  const PixelSize size = reduced_size(work.project, kUnevenLightSide);
  const ImageU8 inside = small_mask(mask, size);
  std::vector<ImageF> frames = small_frames(work.project.frames.size(), read_frame, size, control);
  const double before = find_uneven_light(frames, inside).ratio;
  const ImageF small_gain = downscale_area(gain, size.width, size.height);
  for (ImageF& frame : frames) apply_gain(frame, small_gain);
  const double after = find_uneven_light(frames, inside).ratio;
  if (after <= kWorse * before) return;
  throw CannotComplete(work.project.file.string() + ": --flat-field estimate would make the light " +
                       (mask.empty() ? "" : "inside the mask ") + "less even, " + hundredths(after) +
                       " : 1 in place of " + hundredths(before) +
                       " : 1; leave it out, or give --flat-field IMAGE, a photograph of a uniform surface");
}

std::vector<HistoryWarning> look_at_light(const HistoryWriter& writer, const IngestWork& work, const fs::path& folder,
                                          const ImageU8& mask, const ImageU8& given, SeriesLight report,
                                          const RunControl& control) {
  const CaptureProject& project = work.project;
  const fs::path file = folder / kSurveyFile;
  Json survey = fs::exists(file) ? load_json(file) : survey_of_one();
  const PixelSize size = reduced_size(project, kUnevenLightSide);
  if (!project.rig) {  // A known lamp's light is divided out.
    report.uneven = find_uneven_light(small_frames(writer.manifest(), folder, size, control), small_mask(mask, size));
    report.uneven->is_inside_mask = !given.empty();
  }
  const RepairTables& tables = repair_tables(work, folder);
  if (!tables.flat_field.empty()) report.flat_field = flat_field_report(tables.flat_field);
  if (report.flat_field && work.options.repair.flat_field == kFlatFieldOfFirst) {
    const fs::path share_file = folder / light_share_file(static_cast<int>(project.frames.size()) - 1);
    report.flat_field->last_shares =
        JsonReader(share_file.string(), load_json(share_file)).member("shares").numbers(3, between(0, 1));
  }
  if (!tables.factors.empty()) {
    std::vector<int> unsure;
    for (const Json& pair : survey.at("pairs")) {
      const FramePair read = pair_from_json(JsonReader(file.string(), pair));
      if (!read.change.light.is_sure()) unsure.push_back(read.frame);
    }
    report.deflicker = deflicker_report(project.frames, tables.factors, unsure);
  }
  report.exif = exif_exposures(project.frames);
  const bool is_divided =
      project.reference_patch.has_value() || project.chart.has_value() || divides_exif_exposure(work);
  add_light_report(survey, report);
  save_json(file, survey);
  if (is_divided) report.exif.reset();  // Exposures that vary by EXIF are no fault any more.
  return light_warnings(report, work.options.repair.flat_field, static_cast<int>(project.frames.size()));
}

}  // namespace patinate::capture
