#include "libcommon/history/footprint.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libcommon/history/material_range.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// 255 where any channel says something: 0 is "not known".
ImageU8 known_pixels(const ImageF& values) {
  ImageU8 known(values.width(), values.height());
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      const auto pixel = values.pixel(x, y);
      known.at(x, y) = std::any_of(pixel.begin(), pixel.end(), [](float v) { return v != 0.0f; }) ? 255 : 0;
    }
  }
  return known;
}

/// 0 where nothing was known; normals become unit again.
void restore_known(const std::string& name, const ImageU8& known, ImageF& values) {
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      const auto pixel = values.pixel(x, y);
      float scale = known.at(x, y) != 0 ? 1.0f : 0.0f;
      if (name == "normal" && scale != 0.0f) {
        const float length = std::sqrt(pixel[0] * pixel[0] + pixel[1] * pixel[1] + pixel[2] * pixel[2]);
        scale = length > 0.0f ? 1.0f / length : 0.0f;
      }
      for (float& v : pixel) v *= scale;
    }
  }
}

}  // namespace

ImageF mean_over_footprint(ImageF values, const ImageU8& mask, double footprint_px) {
  if (!(footprint_px >= 0.0 && footprint_px <= kLargestFootprint_px))
    throw InvalidInput("footprint: use 0 to 256 pixels");
  if (footprint_px <= kMinFootprint_px) return values;
  return gaussian_blur(values, mask, std::sqrt((footprint_px * footprint_px - 1.0) / 12.0));
}

ImageF mean_extra_over_footprint(const std::string& name, ImageF values, double footprint_px) {
  if (footprint_px <= kMinFootprint_px) return values;
  if (name == "metalness") return mean_over_footprint(std::move(values), {}, footprint_px);  // 0 is no metal.
  const ImageU8 is_known = known_pixels(values);
  values = mean_over_footprint(std::move(values), is_known, footprint_px);
  restore_known(name, is_known, values);
  return values;
}

FootprintHistory::FootprintHistory(std::shared_ptr<const History> history, double footprint_px)
    : history_(std::move(history)), footprint_px_(footprint_px) {
  if (facts().has_mask) mask_ = history_->read_mask();
}

ImageF FootprintHistory::load_frame(std::size_t frame) const {
  return mean_over_footprint(history_->read_frame(static_cast<int>(frame)), mask_, footprint_px_);
}

ImageF FootprintHistory::load_map(std::size_t map) const {
  const std::string& name = facts().maps[map];
  if (!is_material_map(name)) return history_->read_map(name);
  return mean_extra_over_footprint(name, history_->read_map(name), footprint_px_);
}

ImageF FootprintHistory::load_frame_extra(std::size_t frame, std::size_t extra) const {
  const std::string& name = facts().frames[frame].extras[extra];
  return mean_extra_over_footprint(name, *history_->read_frame_extra(static_cast<int>(frame), name), footprint_px_);
}

}  // namespace patinate
