#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "capture/timelapse/gloss_step.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// The flash's highlight in the roi; empty when there is none, or highlights are kept.
ImageU8 standing_highlight(const IngestWork& work, const RunControl& control) {
  if (work.options.repair.highlights != HighlightRule::Mask) return {};
  if (work.project.is_handheld()) return {};  // Nothing stands still.
  if (work.project.rig) return {};            // The highlight of a known lamp is taken off.
  const CaptureProject& project = work.project;
  const PixelRectangle& roi = project.roi;
  constexpr float kSaturation = 1.0f;
  const auto read_frame = [&](int i) {
    return crop(read_whole_photo(project, project.frames[i]), roi.x, roi.y, roi.width, roi.height);
  };
  ImageU8 highlight = find_standing_highlight(static_cast<int>(project.frames.size()), read_frame, kSaturation,
                                              work.options.repair.highlight_options, control);
  const auto values = highlight.values();
  return std::any_of(values.begin(), values.end(), [](std::uint8_t v) { return v != 0; }) ? highlight : ImageU8();
}

/// Reader of what every frame's pixels show, with the highlight that stands still.
class ValidityReader {
 public:
  ValidityReader(const IngestWork& work, const fs::path& folder, ImageU8 highlight)
      : work_(work), folder_(folder), highlight_(std::move(highlight)) {}

  [[nodiscard]] ImageU8 read(int index) const {
    ImageU8 validity = read_validity(folder_, index);
    if (highlight_.empty()) return validity;
    const RepairTables& t = repair_tables(work_, folder_);
    const ImageU8 there = t.motions.empty() ? highlight_ : mask_in_place(highlight_, t.motions[index]);
    ImageF shares(there.width(), there.height());
    std::transform(there.values().begin(), there.values().end(), shares.values().begin(),
                   [](std::uint8_t v) { return v != 0 ? 1.0f : 0.0f; });
    mark_invalid(shares, Validity::Highlight, validity);
    return validity;
  }

 private:
  const IngestWork& work_;
  const fs::path& folder_;
  ImageU8 highlight_;
};

bool is_all(const ImageU8& mask, std::uint8_t value) {
  const auto values = mask.values();
  return std::all_of(values.begin(), values.end(), [value](std::uint8_t v) { return v == value; });
}

/// Writes masks and filled frames. @returns Per frame: has a mask of its own.
std::vector<char> write_frames(const fs::path& folder, const FillPlan& plan, const ValidityReader& validity,
                               const std::vector<double>& times, const SeriesGloss* gloss, const RunControl& control) {
  std::vector<char> has_mask(times.size(), 0);
  const auto read_validity = [&](int i) { return validity.read(i); };
  const auto read_frame = [&](int i) {
    ImageF color = read_color(folder / HistoryWriter::frame_file(i));
    return gloss != nullptr ? gloss->albedo(i, color) : color;
  };
  parallel_for(static_cast<std::int64_t>(times.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    const int i = static_cast<int>(begin);
    const ImageU8 mask = frame_mask(i, validity.read(i), plan);
    if (!is_all(mask, 255)) {
      fs::create_directories(folder / HistoryWriter::frame_mask_file(i).parent_path());
      write_codes(folder / HistoryWriter::frame_mask_file(i), mask);
      has_mask[i] = 1;
    }
    if (plan.needs_fill[i] == 0) return;
    const ImageF filled = fill_frame(i, times, plan, read_validity, read_frame);
    fs::create_directories(folder / HistoryWriter::filled_frame_file(i).parent_path());
    write_exr(folder / HistoryWriter::filled_frame_file(i), filled, {"R", "G", "B"}, ExrDepth::Half);
  });
  return has_mask;
}

void complete_survey(const fs::path& folder, double masked_share, double outside_share) {
  const fs::path file = folder / kSurveyFile;
  if (!fs::exists(file)) return;
  Json json = load_json(file);
  json["masked_share"] = masked_share;
  json["outside_share"] = outside_share;
  save_json(file, json);
}

}  // namespace

ImageU8 read_validity(const fs::path& folder, int index) {
  constexpr float kCodes = 255.0f;
  const ImageF values = read_gray(folder / validity_file(index));
  ImageU8 codes(values.width(), values.height());
  std::transform(values.values().begin(), values.values().end(), codes.values().begin(),
                 [](float v) { return static_cast<std::uint8_t>(std::floor(v * kCodes + 0.5f)); });
  return codes;
}

ImageU8 mask_frames(HistoryWriter& writer, const IngestWork& work, const fs::path& folder, const ImageU8& mask,
                    const SeriesGloss* gloss, const RunControl& control) {
  if (!has_validity(work)) return mask;
  std::vector<double> times;
  for (const CapturePhoto& frame : work.project.frames) times.push_back(frame.time);
  const ValidityReader validity(work, folder, standing_highlight(work, control.part(0.0, 0.3)));
  const FillPlan plan = plan_fill(
      times, [&](int i) { return validity.read(i); }, work.options.repair.fill, control.part(0.3, 0.5));
  const std::vector<char> has_mask = write_frames(folder, plan, validity, times, gloss, control.part(0.5, 1.0));
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (has_mask[i] != 0) writer.add_written_frame_mask(static_cast<int>(i));
    if (plan.needs_fill[i] != 0) writer.add_filled_frame(static_cast<int>(i));
  }
  double num_inside = 0.0, num_outside = 0.0;
  ImageU8 result = mask.empty() ? ImageU8(plan.inside.width(), plan.inside.height(), 1, 255) : mask;
  for (std::int64_t p = 0; p < result.num_pixels(); ++p) {
    if (result.data()[p] == 0) continue;
    (plan.inside.data()[p] != 0 ? num_inside : num_outside) += 1.0;
    result.data()[p] = plan.inside.data()[p];
  }
  complete_survey(folder, plan.invalid_share, num_outside / std::max(1.0, num_inside + num_outside));
  if (num_inside == 0.0) {
    throw IoError(work.project.file.string(),
                  "no pixel is known at all times: all are saturated, in a highlight or out of view in some frame "
                  "too long to be filled; give --highlights keep, or leave frames out (`exclude`)");
  }
  return mask.empty() && num_outside == 0.0 ? mask : result;
}

}  // namespace patinate::capture
