#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/stability/first_light.h"
#include "capture/stability/stabilize.h"
#include "capture/timelapse/chart_step.h"
#include "capture/timelapse/frame_photo.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/json.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// Motion of pixels in the roi as a map from roi pixels to pixels of the whole photograph.
Eigen::Affine2d photo_from_roi(const PixelRectangle& roi, const Eigen::Affine2d& motion) {
  return Eigen::Translation2d(roi.x, roi.y) * motion;
}

bool is_moved(const Eigen::Affine2d& motion) { return motion.matrix() != Eigen::Affine2d::Identity().matrix(); }

/// 255 -> 1, 0 -> 0.
ImageF as_shares(const ImageU8& set) {
  ImageF shares(set.width(), set.height());
  std::transform(set.values().begin(), set.values().end(), shares.values().begin(),
                 [](std::uint8_t v) { return v != 0 ? 1.0f : 0.0f; });
  return shares;
}

/// A part of the photograph (the roi) where the first frame has it. @param seen  Becomes what the photograph shows of
/// it.
ImageF in_place(const ImageF& whole, const PixelRectangle& roi, const Eigen::Affine2d& motion, ImageU8& seen) {
  if (is_moved(motion))
    return resample_frame(whole, photo_from_roi(roi, motion), roi.width, roi.height, seen, one_thread());
  seen = ImageU8(roi.width, roi.height, 1, 255);
  return crop(whole, roi.x, roi.y, roi.width, roi.height);
}

}  // namespace

bool has_validity(const IngestWork& work) {
  return work.options.repair.highlights == HighlightRule::Mask ||
         (work.options.repair.stabilize && work.project.frames.size() > 1) || work.project.is_handheld();
}

fs::path validity_file(int index) {
  return "survey/validity-" + zero_padded(static_cast<std::uint64_t>(index), 4) + ".png";
}

fs::path light_share_file(int index) {
  return "survey/light-" + zero_padded(static_cast<std::uint64_t>(index), 4) + ".json";
}

fs::path clipped_file(int index) {
  return "survey/clipped-" + zero_padded(static_cast<std::uint64_t>(index), 4) + ".json";
}

const RepairTables& repair_tables(const IngestWork& work, const fs::path& folder) {
  const std::lock_guard lock(work.repairs->mutex);
  RepairTables& t = *work.repairs;
  if (t.is_loaded) return t;
  const RepairOptions& options = work.options.repair;
  if ((options.stabilize || options.deflicker) && work.project.frames.size() > 1) {
    const Json json = load_json(folder / kSurveyFile);
    for (const Json& m : json.value("motions", Json::array())) {
      Eigen::Affine2d motion = Eigen::Affine2d::Identity();
      for (std::size_t k = 0; k < 6; ++k)
        motion(static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3)) = m.at(k).get<double>();
      t.motions.push_back(motion);
    }
    for (const Json& f : json.value("factors", Json::array())) t.factors.push_back(f.get<std::array<double, 3>>());
  }
  if (!options.flat_field.empty()) {
    const fs::path file = folder / kFlatFieldFile;
    t.flat_field = read_channels(file, {"R", "G", "B"});
  }
  t.is_loaded = true;
  return t;
}

void mark_invalid(const ImageF& shares, Validity code, ImageU8& validity) {
  constexpr float kShare = 0.1f;  // A reduced pixel takes a code that a tenth of its pixels has.
  const ImageF low = downscale_area(shares, validity.width(), validity.height(), one_thread());
  for (std::int64_t p = 0; p < validity.num_pixels(); ++p) {
    if (low.data()[p] > kShare) validity.data()[p] = std::min(validity.data()[p], static_cast<std::uint8_t>(code));
  }
}

ImageU8 mask_in_place(const ImageU8& mask, const Eigen::Affine2d& motion) {
  if (!is_moved(motion)) return mask;
  constexpr float kInside = 0.25f;  // A reduced pixel is inside from a quarter of its pixels on.
  ImageU8 unused, result(mask.width(), mask.height());
  const ImageF there = resample_frame(as_shares(mask), motion, mask.width(), mask.height(), unused, one_thread());
  std::transform(there.values().begin(), there.values().end(), result.values().begin(),
                 [](float v) { return static_cast<std::uint8_t>(v > kInside ? 255 : 0); });
  return result;
}

ImageF develop_frame(const IngestWork& work, int index, const fs::path& folder) {
  const RepairOptions& options = work.options.repair;
  const CaptureProject& project = work.project;
  const PixelRectangle& roi = project.roi;
  const CapturePhoto& photo = project.frames[index];
  const RepairTables& t = repair_tables(work, folder);
  const Eigen::Affine2d motion = t.motions.empty() ? Eigen::Affine2d::Identity() : t.motions[index];
  ClippedPixels clipped;
  const ImageF whole = read_whole_photo(project, photo, &clipped);
  ImageF true_color = project.chart ? whole : ImageF();  // Saturation shows in the photograph as it is.
  clipped.num_outside += apply_chart(work, index, folder, true_color);
  if (may_be_clipped(project, photo)) {
    save_json(folder / clipped_file(index),
              Json{{"outside", clipped.num_outside}, {"beyond", clipped.num_beyond}, {"pixels", whole.num_pixels()}});
  }
  const auto lay = [&](const ImageF& image, ImageU8& shown) {
    return project.is_handheld() ? lay_in_roi(work, index, folder, image, shown) : in_place(image, roi, motion, shown);
  };
  ImageU8 seen;
  ImageF color = lay(project.chart ? true_color : whole, seen);
  apply_light_gain(work, index, folder, color);
  if (project.is_handheld()) keep_opaque(work, index, folder, seen);
  if (!t.flat_field.empty()) {
    // The lamp stands with the camera: its fall-off moves with the photograph.
    ImageU8 unused;
    const ImageF gain = is_moved(motion)
                            ? resample_frame(t.flat_field, motion, roi.width, roi.height, unused, one_thread())
                            : t.flat_field;
    if (options.flat_field == kFlatFieldOfFirst) {
      const std::array<double, 3> shares = remaining_first_light(color, gain);
      save_json(folder / light_share_file(index), Json{{"shares", shares}});
      apply_first_light_gain(color, gain, shares);
    } else {
      apply_gain(color, gain);
    }
  }
  if (!t.factors.empty()) {
    const auto& factor = t.factors[index];
    for (std::int64_t i = 0; i < 3 * color.num_pixels(); ++i) color.data()[i] *= static_cast<float>(factor[i % 3]);
  }
  if (has_validity(work)) {
    ImageU8 validity(project.width(), project.height(), 1, static_cast<std::uint8_t>(Validity::Valid));
    if (options.highlights == HighlightRule::Mask) {
      const SaturationPhoto seen_by_sensor = saturation_photo(project, photo, whole);
      const ImageU8 saturated = find_saturated(seen_by_sensor.photo, seen_by_sensor.level, options.highlight_options);
      ImageU8 unused;
      const ImageF there = lay(as_shares(saturated), unused);
      mark_invalid(there, Validity::Saturated, validity);
    }
    for (std::uint8_t& v : seen.values()) v = v != 0 ? 0 : 255;
    mark_invalid(as_shares(seen), Validity::OutOfView, validity);
    write_codes(folder / validity_file(index), validity);
  }
  return downscale_area(color, project.width(), project.height(), one_thread());
}

}  // namespace patinate::capture
