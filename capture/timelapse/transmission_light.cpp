#include <nlohmann/json.hpp>

#include "capture/alignment/alignment.h"
#include "capture/timelapse/frame_photo.h"
#include "capture/timelapse/ingest_work.h"
#include "patinate/core/error.h"
#include "patinate/core/json.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// Brightness, H x W x 1.
ImageF light_of(const ImageF& color) {
  ImageF light(color.width(), color.height());
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) light.at(x, y) = luminance(color.pixel(x, y));
  }
  return light;
}

/// The last frame shows what the transmission photograph shows: the cracks.
ImageAlignment align_transmission(const IngestWork& work, const fs::path& folder, const ImageF& photo,
                                  const RunControl& control) {
  const CaptureProject& project = work.project;
  const TransmissionPhotos& transmission = *project.transmission;
  if (transmission.align == TransmissionPhotos::Align::Points) return align_points(transmission.points);
  const CapturePhoto& last = project.frames.back();
  const std::string advice =
      "; give four pairs of points instead, \"align\": [[[x, y] in it, [x, y] in the frames], ...]";
  const int last_index = static_cast<int>(project.frames.size()) - 1;
  const ImageF reference = light_of(read_frame_whole(work, last_index, folder));
  ImageAlignment found;
  try {
    found = align_images(reference, photo, control);
  } catch (const InvalidInput& e) {
    throw IoError(transmission.photo.string(), std::string("cannot be aligned (") + e.what() + ")" + advice);
  }
  if (found.status == AlignmentStatus::Converged) return found;
  throw IoError(transmission.photo.string(), "cannot be aligned with " + last.name() + " (" +
                                                 alignment_status_text(found.status) + "; " +
                                                 std::to_string(found.num_matches) + " details match, " +
                                                 std::to_string(found.num_inliers) + " agree)" + advice);
}

void write_alignment(const fs::path& file, const ImageAlignment& alignment) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    const auto row = alignment.reference_from_image.row(r);
    rows.push_back({row(0), row(1), row(2)});
  }
  save_json(file, Json{{"homography", rows},
                       {"agreeing", alignment.num_inliers},
                       {"residual_px", alignment.residual_px},
                       {"correlation", alignment.correlation}});
}

}  // namespace

TransmissionLight read_transmission_light(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  const CaptureProject& project = work.project;
  TransmissionLight light;
  if (!project.transmission) return light;
  const TransmissionPhotos& files = *project.transmission;
  const auto read_light = [&](const fs::path& file) { return light_of(read_color(file, project.response)); };
  const ImageF photo = read_light(files.photo);
  const ImageF blank = files.blank ? read_light(*files.blank) : ImageF();
  if (files.align == TransmissionPhotos::Align::None) {
    light.photo = to_history_size(photo, project, files.photo);
    if (!blank.empty()) light.blank = to_history_size(blank, project, *files.blank);
    return light;
  }
  const ImageAlignment alignment = align_transmission(work, folder, photo, control);
  write_alignment(folder / kTransmissionFile, alignment);
  const auto in_frames = [&](const ImageF& image) {
    return warp_image(image, alignment.reference_from_image, project.photo_width, project.photo_height);
  };
  const WarpedImage warped = in_frames(photo);
  light.photo = to_history_size(warped.values, project, files.photo);
  if (!blank.empty()) light.blank = to_history_size(in_frames(blank).values, project, *files.blank);
  ImageF share(project.photo_width, project.photo_height);
  for (std::int64_t i = 0; i < share.num_pixels(); ++i) share.data()[i] = warped.coverage.data()[i] != 0 ? 1.0f : 0.0f;
  share = to_history_size(share, project, files.photo);
  light.reached = ImageU8(project.width(), project.height());
  bool is_all = true;
  for (std::int64_t i = 0; i < share.num_pixels(); ++i) {
    const bool is_whole = share.data()[i] > 0.999f;
    light.reached.data()[i] = is_whole ? 255 : 0;
    is_all = is_all && is_whole;
  }
  if (is_all) light.reached = {};
  return light;
}

}  // namespace patinate::capture
