#include <algorithm>
#include <cmath>
#include <mutex>

#include "capture/project/capture_project.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace {

/// 255 where at least half of a history pixel is inside.
void keep_inside(const ImageF& coverage, ImageU8& mask) {
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (coverage.at(x, y) < 0.5f) mask.at(x, y) = 0;
    }
  }
}

bool is_blank(const ImageU8& mask) {
  const auto values = mask.values();
  return std::all_of(values.begin(), values.end(), [](std::uint8_t v) { return v == 0; });
}

ImageF coverage_of(const ImageU8& mask) {
  ImageF coverage(mask.width(), mask.height());
  std::transform(mask.values().begin(), mask.values().end(), coverage.values().begin(),
                 [](std::uint8_t v) { return v != 0 ? 1.0f : 0.0f; });
  return coverage;
}

}  // namespace

ImageF to_history_size(const ImageF& image, const CaptureProject& project, const std::filesystem::path& file) {
  if (image.width() == project.photo_width && image.height() == project.photo_height) {
    const PixelRectangle& roi = project.roi;
    const ImageF part = crop(image, roi.x, roi.y, roi.width, roi.height);
    RunControl one_thread;  // Frames run side by side already.
    one_thread.num_threads = 1;
    return downscale_area(part, project.width(), project.height(), one_thread);
  }
  if (image.width() == project.width() && image.height() == project.height()) return image;
  throw IoError(file.string(), "is " + std::to_string(image.width()) + " x " + std::to_string(image.height()) +
                                   " pixels; expected " + std::to_string(project.photo_width) + " x " +
                                   std::to_string(project.photo_height) + ", as the frames");
}

namespace {

constexpr float kLargestHalf = 65504.0f;  ///< Largest finite half float.

ImageF read_as(const CapturePhoto& photo, const Response& response) {
  return photo.stream ? color_of(photo.stream->read(photo.image), response) : read_color(photo.file, response);
}

/// Whether codes are decoded by what the file says of its color.
bool is_decoded_as_said(const CaptureProject& project, const CapturePhoto& photo) {
  return photo.is_encoded && (!photo.has_codes || project.response.kind == Response::Kind::File);
}

}  // namespace

bool may_be_clipped(const CaptureProject& project, const CapturePhoto& photo) {
  return project.chart || is_decoded_as_said(project, photo) || !(photo.has_codes || photo.is_raw);
}

ImageF read_whole_photo(const CaptureProject& project, const CapturePhoto& photo, ClippedPixels* clipped) {
  ImageF color = read_as(photo, project.response);
  if (!may_be_clipped(project, photo)) return color;
  const bool is_converted = is_decoded_as_said(project, photo);
  // Rounding of a profile's numbers may lead below 0: that is no color outside.
  constexpr float kRounding = 1e-3f;
  for (std::int64_t i = 0; i < color.num_pixels(); ++i) {
    float* pixel = color.data() + 3 * i;
    bool is_outside = false, is_beyond = false;
    for (int c = 0; c < 3; ++c) {
      is_outside = is_outside || (is_converted && pixel[c] < -kRounding);
      is_beyond = is_beyond || std::abs(pixel[c]) > kLargestHalf;
      pixel[c] = std::clamp(pixel[c], is_converted ? 0.0f : -kLargestHalf, kLargestHalf);
    }
    if (clipped != nullptr) clipped->num_outside += is_outside, clipped->num_beyond += is_beyond;
  }
  return color;
}

SaturationPhoto saturation_photo(const CaptureProject& project, const CapturePhoto& photo, const ImageF& color) {
  constexpr float kCode = 253.5f / 255.0f;  // Codes from 254 on count as saturated.
  if (photo.is_raw) return {color, kCode};
  if (!photo.has_codes) return {color, kLargestHalf};
  if (!is_decoded_as_said(project, photo)) return {color, project.response.linear_from_code(kCode)};
  constexpr Response kSrgb{.kind = Response::Kind::Srgb};
  return {read_as(photo, kSrgb), kSrgb.linear_from_code(kCode)};
}

ImageF read_photo(const CaptureProject& project, const std::filesystem::path& file) {
  return to_history_size(read_color(file, project.response), project, file);
}

ImageF read_photo(const CaptureProject& project, const CapturePhoto& photo) {
  return to_history_size(read_whole_photo(project, photo), project, photo.file);
}

ImageU8 read_capture_mask(const CaptureProject& project, const RunControl& control) {
  ImageU8 mask(project.width(), project.height(), 1, 255);
  bool is_given = false;
  if (project.mask) {
    keep_inside(to_history_size(coverage_of(read_mask(*project.mask)), project, *project.mask), mask);
    if (is_blank(mask)) {
      throw IoError(project.mask->string(), "leaves nothing inside; a mask must not be 0 everywhere (in the roi)");
    }
    is_given = true;
  }
  std::mutex mutex;  // The order in which frames are taken off the mask does not matter.
  parallel_for(static_cast<std::int64_t>(project.frames.size()), 1, control, [&](std::int64_t begin, std::int64_t) {
    const CapturePhoto& photo = project.frames[begin];
    if (!photo.has_alpha || project.is_handheld()) return;  // Laid over another one, it is out of view there.
    const ImageF values =
        photo.stream ? channel_of(photo.stream->read(photo.image), "A") : read_channels(photo.file, {"A"});
    const ImageF alpha = to_history_size(values, project, photo.file);
    const std::lock_guard lock(mutex);
    keep_inside(alpha, mask);
  });
  if (is_blank(mask)) {
    throw IoError(project.file.string(),
                  "no pixel is opaque in every frame (and inside the mask); the object must stay in place");
  }
  const auto values = mask.values();
  const bool is_everything = std::all_of(values.begin(), values.end(), [](std::uint8_t v) { return v != 0; });
  if (is_everything && !is_given) return {};
  return mask;
}

}  // namespace patinate::capture
