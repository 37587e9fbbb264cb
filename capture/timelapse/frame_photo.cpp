#include "capture/timelapse/frame_photo.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "capture/handheld/lay_photo.h"
#include "capture/timelapse/align_step.h"
#include "capture/timelapse/chart_step.h"
#include "capture/timelapse/patch_step.h"
#include "libcommon/image/filters.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

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

RunControl one_thread() {
  RunControl control;  // Frames run side by side already.
  control.num_threads = 1;
  return control;
}

ImageU8 opaque_part(const CapturePhoto& photo) {
  if (!photo.has_alpha) return {};
  const ImageF alpha =
      photo.stream ? channel_of(photo.stream->read(photo.image), "A") : read_channels(photo.file, {"A"});
  if (std::all_of(alpha.values().begin(), alpha.values().end(), [](float a) { return a >= 0.5f; })) return {};
  ImageU8 opaque(alpha.width(), alpha.height());
  std::transform(alpha.values().begin(), alpha.values().end(), opaque.values().begin(),
                 [](float a) { return static_cast<std::uint8_t>(a >= 0.5f ? 255 : 0); });
  return opaque;
}

ImageF read_frame_whole(const IngestWork& work, int index, const fs::path& folder) {
  const CaptureProject& project = work.project;
  const ImageF photo = read_colored_photo(work, index, folder);
  if (!project.is_handheld()) return photo;
  ImageU8 unused;
  return lay_photo(photo, place_of(work, index, folder), project.photo_width, project.photo_height, unused);
}

ImageF lay_in_rectangle(const IngestWork& work, int index, const fs::path& folder, const ImageF& image,
                        const PixelRectangle& part, ImageU8& shown) {
  if (!work.project.is_handheld()) {
    shown = ImageU8(part.width, part.height, 1, 255);
    return roi_of(image, part);
  }
  Eigen::Matrix3d part_from_reference = Eigen::Matrix3d::Identity();
  part_from_reference(0, 2) = -part.x;
  part_from_reference(1, 2) = -part.y;
  return lay_photo(image, part_from_reference * place_of(work, index, folder), part.width, part.height, shown,
                   one_thread());
}

ImageF lay_in_roi(const IngestWork& work, int index, const fs::path& folder, const ImageF& image, ImageU8& shown) {
  return lay_in_rectangle(work, index, folder, image, work.project.roi, shown);
}

ImageF read_colored_photo(const IngestWork& work, int index, const fs::path& folder) {
  ImageF photo = read_whole_photo(work.project, work.project.frames[index]);
  apply_chart(work, index, folder, photo);
  return photo;
}

void apply_light_gain(const IngestWork& work, int index, const fs::path& folder, ImageF& color) {
  const std::array<double, 3> gain = light_gain(work, index, folder);
  if (gain == std::array<double, 3>{1.0, 1.0, 1.0}) return;
  for (std::int64_t i = 0; i < 3 * color.num_pixels(); ++i) color.data()[i] *= static_cast<float>(gain[i % 3]);
}

void keep_opaque(const IngestWork& work, int index, const fs::path& folder, ImageU8& shown) {
  const CapturePhoto& photo = work.project.frames[index];
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
  const auto read = [&](int i) { return read_colored_photo(work, i, folder); };
  if (!project.is_handheld()) {
    ImageF part = roi_of(read(index), project.roi);
    apply_light_gain(work, index, folder, part);
    return part;
  }
  ImageU8 shown;
  ImageF color = lay_in_roi(work, index, folder, read(index), shown);
  keep_opaque(work, index, folder, shown);
  const bool is_whole =
      std::all_of(shown.values().begin(), shown.values().end(), [](std::uint8_t v) { return v != 0; });
  if (!is_whole && index != project.reference) {
    PlaceTable& table = *work.places;
    std::call_once(table.once_reference, [&] { table.reference = roi_of(read(project.reference), project.roi); });
    fill_from_reference(color, shown, table.reference);
  }
  apply_light_gain(work, index, folder, color);
  return color;
}

}  // namespace patinate::capture
