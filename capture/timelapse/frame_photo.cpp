#include "capture/timelapse/frame_photo.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "capture/handheld/lay_photo.h"
#include "capture/timelapse/align_step.h"
#include "libcommon/image/filters.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

RunControl one_thread() {
  RunControl control;  // Frames run side by side already.
  control.num_threads = 1;
  return control;
}

ImageF roi_of(const ImageF& whole, const PixelRectangle& roi) {
  return crop(whole, roi.x, roi.y, roi.width, roi.height);
}

/// Fills what is not shown from the reference, times the ratio of the two where both are known.
void fill_from_reference(ImageF& color, const ImageU8& shown, const ImageF& reference) {
  std::array<double, 3> here{}, there{};
  for (std::int64_t i = 0; i < color.num_pixels(); ++i) {
    if (shown.data()[i] == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      here[c] += static_cast<double>(color.data()[3 * i + static_cast<std::int64_t>(c)]);
      there[c] += static_cast<double>(reference.data()[3 * i + static_cast<std::int64_t>(c)]);
    }
  }
  for (std::int64_t i = 0; i < color.num_pixels(); ++i) {
    if (shown.data()[i] != 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int64_t at = 3 * i + static_cast<std::int64_t>(c);
      const double gain = here[c] > 0.0 && there[c] > 0.0 ? here[c] / there[c] : 1.0;
      color.data()[at] = static_cast<float>(gain * static_cast<double>(reference.data()[at]));
    }
  }
}

}  // namespace

ImageU8 opaque_part(const CapturePhoto& photo) {
  if (!photo.has_alpha) return {};
  const ImageF alpha =
      photo.stream ? channel_of(photo.stream->read(photo.image), "A") : read_channels(photo.file, {"A"});
  ImageU8 opaque(alpha.width(), alpha.height());
  std::transform(alpha.values().begin(), alpha.values().end(), opaque.values().begin(),
                 [](float a) { return static_cast<std::uint8_t>(a >= 0.5f ? 255 : 0); });
  return opaque;
}

ImageF read_frame_whole(const IngestWork& work, int index, const fs::path& folder) {
  const CaptureProject& project = work.project;
  const ImageF photo = read_whole_photo(project, project.frames[static_cast<std::size_t>(index)]);
  if (!project.is_handheld()) return photo;
  ImageU8 unused;
  return lay_photo(photo, place_of(work, index, folder), project.photo_width, project.photo_height, unused);
}

ImageF lay_in_roi(const IngestWork& work, int index, const fs::path& folder, const ImageF& image, ImageU8& shown) {
  const PixelRectangle& roi = work.project.roi;
  Eigen::Matrix3d roi_from_reference = Eigen::Matrix3d::Identity();
  roi_from_reference(0, 2) = -roi.x;
  roi_from_reference(1, 2) = -roi.y;
  return lay_photo(image, roi_from_reference * place_of(work, index, folder), roi.width, roi.height, shown,
                   one_thread());
}

void keep_opaque(const IngestWork& work, int index, const fs::path& folder, ImageU8& shown) {
  const CapturePhoto& photo = work.project.frames[static_cast<std::size_t>(index)];
  const ImageU8 opaque = opaque_part(photo);
  if (opaque.empty()) return;
  ImageF shares(opaque.width(), opaque.height());
  std::transform(opaque.values().begin(), opaque.values().end(), shares.values().begin(),
                 [](std::uint8_t v) { return v != 0 ? 1.0f : 0.0f; });
  ImageU8 unused;
  const ImageF there = lay_in_roi(work, index, folder, shares, unused);
  for (std::int64_t i = 0; i < shown.num_pixels(); ++i) {
    if (there.data()[i] < 0.5f) shown.data()[i] = 0;
  }
}

ImageF read_frame_roi(const IngestWork& work, int index, const fs::path& folder) {
  const CaptureProject& project = work.project;
  const auto read = [&](int i) { return read_whole_photo(project, project.frames[static_cast<std::size_t>(i)]); };
  if (!project.is_handheld()) return roi_of(read(index), project.roi);
  ImageU8 shown;
  ImageF color = lay_in_roi(work, index, folder, read(index), shown);
  keep_opaque(work, index, folder, shown);
  const bool is_whole =
      std::all_of(shown.values().begin(), shown.values().end(), [](std::uint8_t v) { return v != 0; });
  if (!is_whole && index != project.reference)
    fill_from_reference(color, shown, roi_of(read(project.reference), project.roi));
  return color;
}

}  // namespace patinate::capture
