#include "capture/timelapse/background_step.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "capture/background/background.h"
#include "capture/timelapse/repair_steps.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

using Kind = BackgroundRule::Kind;
constexpr double kMuchAlone = 0.05;  ///< Share of the object: more than its outline moves by.
constexpr double kMixed_px = 3.0;  ///< Pixels of the photographs that JPEG's half resolution of color mixes at an edge.
constexpr double kSmooth_px = 1.0;       ///< Pixels of the reduced ones: grain makes the outline ragged.
constexpr std::size_t kMostFrames = 48;  ///< That are compared for what never changes.

/// Where frames and what they show come from.
struct FrameSource {
  std::function<ImageF(int)> read_frame;
  std::function<ImageU8(int)> read_known;  ///< Reads a mask of the reduced size; empty when all is shown.
};

ImageF reduced_codes(const FrameSource& source, int index, const PixelSize& size) {
  ImageF codes = downscale_area(source.read_frame(index), size.width, size.height);
  std::transform(codes.values().begin(), codes.values().end(), codes.values().begin(), srgb_from_linear);
  return codes;
}

/// Mask of what the photograph shows; empty when it shows all.
ImageU8 reduced_known(const IngestWork& work, const fs::path& folder, int index, const PixelSize& size) {
  if (!has_validity(work)) return {};
  ImageF shown = read_gray(folder / validity_file(index));
  for (float& v : shown.values()) v = v > 0.0f ? 1.0f : 0.0f;
  const ImageF small = downscale_area(shown, size.width, size.height);
  ImageU8 known(size.width, size.height);
  std::transform(small.values().begin(), small.values().end(), known.values().begin(),
                 [](float v) { return static_cast<std::uint8_t>(v > 0.5f ? 255 : 0); });
  return known;
}

ImageU8 background_of(const IngestWork& work, const FrameSource& source, int index, const PixelSize& size,
                      const BackgroundRule& rule) {
  const ImageF codes = reduced_codes(source, index, size);
  if (rule.kind == Kind::Color) return keyed_background(codes, rule.color);
  PlainBackground plain = plain_background(codes, source.read_known(index));
  if (plain.is_plain()) return std::move(plain.mask);
  throw IoError(work.project.frames[index].name(),
                "has no plain background: " + fixed_percent_text(plain.border_share) +
                    " of its border are of one color; give --mask-background '#rrggbb', or a `mask`, or `exclude` it");
}

std::vector<ImageU8> backgrounds(const IngestWork& work, const FrameSource& source, const PixelSize& size,
                                 const BackgroundRule& rule, const RunControl& control) {
  const std::size_t num_frames = work.project.frames.size();
  if (rule.kind == Kind::Unchanging) {
    std::vector<ImageF> codes;
    const std::size_t count = std::min(num_frames, kMostFrames);
    for (std::size_t k = 0; k < count; ++k) {
      control.throw_if_stopped();
      const std::size_t i = count == 1 ? 0 : k * (num_frames - 1) / (count - 1);
      codes.push_back(reduced_codes(source, static_cast<int>(i), size));
    }
    return {unchanging_background(codes)};
  }
  std::vector<ImageU8> found(num_frames);
  parallel_for(static_cast<std::int64_t>(num_frames), 1, control, [&](std::int64_t begin, std::int64_t) {
    found[begin] = background_of(work, source, static_cast<int>(begin), size, rule);
  });
  return found;
}

/// In how many photographs a pixel is background.
Image<std::int32_t> counts_of(const std::vector<ImageU8>& found) {
  Image<std::int32_t> counts(found.front().width(), found.front().height());
  for (const ImageU8& mask : found) {
    for (std::int64_t i = 0; i < mask.num_pixels(); ++i) counts.data()[i] += mask.data()[i] != 0;
  }
  return counts;
}

/// The object at the history's size, without the rim.
ImageU8 enlarged_object(const Image<std::int32_t>& counts, const CaptureProject& project) {
  cv::Mat object(counts.height(), counts.width(), CV_8U);
  std::transform(counts.values().begin(), counts.values().end(), object.data,
                 [](std::int32_t n) { return static_cast<std::uint8_t>(n == 0 ? 255 : 0); });
  const double factor = static_cast<double>(object.cols) / project.width();
  const int rim = std::max(1, static_cast<int>(std::ceil(kMixed_px * factor)));
  cv::erode(object, object, cv::Mat::ones(3, 3, CV_8U), {-1, -1}, rim, cv::BORDER_REPLICATE);
  cv::GaussianBlur(object, object, {}, kSmooth_px);
  cv::resize(object, object, {project.width(), project.height()}, 0.0, 0.0, cv::INTER_LINEAR);
  ImageU8 result(project.width(), project.height());
  std::transform(object.data, object.data + result.num_pixels(), result.values().begin(),
                 [](std::uint8_t v) { return static_cast<std::uint8_t>(v >= 128 ? 255 : 0); });
  return result;
}

std::vector<HistoryWarning> lone_warnings(const IngestWork& work, const std::vector<ImageU8>& found,
                                          const Image<std::int32_t>& counts) {
  const auto num_object = std::count(counts.values().begin(), counts.values().end(), 0);
  std::vector<HistoryWarning> warnings;
  for (std::size_t k = 0; found.size() > 1 && k < found.size(); ++k) {
    double num_alone = 0.0;
    for (std::int64_t i = 0; i < counts.num_pixels(); ++i)
      num_alone += counts.data()[i] == 1 && found[k].data()[i] != 0 ? 1.0 : 0.0;
    const double share = num_alone / (num_alone + static_cast<double>(num_object));
    if (share < kMuchAlone) continue;
    const std::string name = work.project.frames[k].name();
    warnings.push_back({.about = WarningSubject::Mask,
                        .text = name + " alone shows background on " + fixed_percent_text(share) +
                                " of the object: it moved there, or has the background's color",
                        .cure = "`exclude` it if it moved; give a `mask` if the object has the background's color",
                        .share = share,
                        .photos = {name}});
  }
  return warnings;
}

/// @throws IoError if nothing is left inside.
void keep_object(const IngestWork& work, const Image<std::int32_t>& counts, ImageU8& mask) {
  const ImageU8 object = enlarged_object(counts, work.project);
  if (mask.empty()) mask = ImageU8(object.width(), object.height(), 1, 255);
  bool is_any_left = false;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (object.data()[i] == 0) mask.data()[i] = 0;
    is_any_left = is_any_left || mask.data()[i] != 0;
  }
  if (!is_any_left) {
    throw IoError(work.project.file.string(), "--mask-background " + work.options.background.mask_background +
                                                  " leaves nothing inside: no pixel shows the object in every frame");
  }
}

}  // namespace

std::vector<HistoryWarning> take_background_off(const IngestWork& work, const fs::path& folder, ImageU8& mask,
                                                const RunControl& control) {
  const BackgroundRule rule = background_rule(work.options.background.mask_background);
  if (rule.kind == Kind::Off) return {};
  const PixelSize size = reduced_size(work.project, kBackgroundSide);
  const FrameSource source{[&](int i) { return read_color(folder / HistoryWriter::frame_file(i)); },
                           [&](int i) { return reduced_known(work, folder, i, size); }};
  const std::vector<ImageU8> found = backgrounds(work, source, size, rule, control);
  const Image<std::int32_t> counts = counts_of(found);
  keep_object(work, counts, mask);
  std::vector<HistoryWarning> warnings = lone_warnings(work, found, counts);
  if (std::all_of(counts.values().begin(), counts.values().end(), [](std::int32_t n) { return n == 0; })) {
    warnings.push_back({.about = WarningSubject::Mask,
                        .text = "--mask-background " + work.options.background.mask_background + " finds no background",
                        .cure = "a `mask`, or another kind: plain, unchanging or a color as '#rrggbb'"});
  }
  return warnings;
}

void take_background_off_early(const IngestWork& work, const std::function<ImageF(int)>& read_frame, ImageU8& mask,
                               const RunControl& control) {
  const BackgroundRule rule = background_rule(work.options.background.mask_background);
  if (rule.kind == Kind::Off) return;
  const FrameSource source{read_frame, [](int) { return ImageU8(); }};
  keep_object(work, counts_of(backgrounds(work, source, reduced_size(work.project, kBackgroundSide), rule, control)),
              mask);
}

}  // namespace patinate::capture
