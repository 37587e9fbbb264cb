#include <algorithm>

#include "capture/stability/first_light.h"
#include "capture/timelapse/background_step.h"
#include "capture/timelapse/frame_photo.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kFlatFieldVersion = 3;  ///< Raised whenever the same photographs give another estimate.

constexpr const char* kEstimatedFlatField = "estimate";

bool is_of_frames(const RepairOptions& options) {
  return options.flat_field == kEstimatedFlatField || options.flat_field == kFlatFieldOfFirst;
}

}  // namespace

void check_flat_field(const std::string& flat_field) {
  std::error_code error;
  if (flat_field.empty() || fs::exists(flat_field, error) || error)
    return;  // Other troubles are named by who reads it.
  const std::vector<std::string> words{kEstimatedFlatField, kFlatFieldOfFirst};
  if (std::find(words.begin(), words.end(), flat_field) != words.end()) return;
  throw ParseError("--flat-field: found `" + flat_field +
                   "`, which is no file; expected estimate, first, or a photograph of a uniform surface" +
                   did_you_mean(flat_field, words));
}

ImageF make_flat_field(const IngestWork& work, const fs::path& folder, const RunControl& control) {
  const RepairOptions& options = work.options.repair;
  const CaptureProject& project = work.project;
  if (is_of_frames(options)) {
    const auto read_frame = [&](int i) { return read_frame_roi(work, i, folder); };
    ImageU8 mask = read_capture_mask(project);
    take_background_off_early(work, read_frame, mask, control.part(0.0, 0.3));
    if (options.flat_field == kFlatFieldOfFirst) return first_light_gain(read_frame(0), mask, control.part(0.3, 1.0));
    ImageF gain = estimate_flat_field(static_cast<int>(work.project.frames.size()), read_frame, mask,
                                      options.flat_field_options, control.part(0.3, 0.8));
    refuse_worse_light(work, read_frame, gain, mask, control.part(0.8, 1.0));
    return gain;
  }
  const ImageF light = read_color(options.flat_field, project.response);
  if (light.width() != project.photo_width || light.height() != project.photo_height) {
    throw IoError(options.flat_field, "is " + std::to_string(light.width()) + " x " + std::to_string(light.height()) +
                                          " pixels; a photograph of a uniform surface must be as large as the frames");
  }
  const PixelRectangle& roi = project.roi;
  try {
    return flat_field_from_image(crop(light, roi.x, roi.y, roi.width, roi.height), options.flat_field_options, control);
  } catch (const InvalidInput& e) {
    throw IoError(options.flat_field, e.what());
  }
}

std::string all_photos_key(const IngestWork& work) {
  ContentHash hash;
  for (const std::string& key : work.photo_keys) hash.add(key);
  return hash.hex();
}

std::string flat_field_key(const IngestWork& work) {
  const RepairOptions& options = work.options.repair;
  ContentHash hash;
  hash.add("flat field");
  if (options.flat_field == kFlatFieldOfFirst) {
    hash.add(options.flat_field).add(work.photo_keys.front());
  } else {
    hash.add(is_of_frames(options) ? all_photos_key(work) : hash_file(options.flat_field));
  }
  if (is_of_frames(options)) {  // Inside the mask.
    hash.add(kFlatFieldVersion).add(work.options.background.mask_background);
    if (work.project.mask) hash.add(hash_file(*work.project.mask));
  }
  for (const auto& [name, value] : option_values(options.flat_field_options)) hash.add(name).add(value);
  return hash.hex();
}

}  // namespace patinate::capture
