#include "capture/stability/highlights.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::capture {

namespace {

constexpr double kWhiteShare = 0.6;  ///< Of a window that is white material.
constexpr int kMaxFrames = 16;
constexpr int kLookSide = 512;  ///< Pixels of the longer side at which the standing highlight is looked for.
constexpr int kLeastEarly = 2;
constexpr double kLeastCore = 0.016;  ///< Of the shorter side, across: wet grains glint in smaller spots.
constexpr float kNearlySaturated =
    0.75f;                      ///< Of the saturated value, in the darkest channel: lossy files soften the plateau.
constexpr int kEarlyPart = 32;  ///< One in so many frames, the first ones: what grows is not there yet.
constexpr float kLeastGround = 0.01f;

int window_radius(int width, int height, const HighlightOptions& options) {
  return std::max(1, static_cast<int>(std::lround(0.5 * options.width_share * std::min(width, height))));
}

/// Pixels in some window of which the set covers kWhiteShare, as far as they can be seen from its middle.
cv::Mat wide_areas(const cv::Mat& set, int radius) {
  cv::Mat share;
  const cv::Size window(2 * radius + 1, 2 * radius + 1);
  cv::Mat ones;
  set.convertTo(ones, CV_32F, 1.0 / 255.0);
  cv::boxFilter(ones, share, CV_32F, window, {-1, -1}, true, cv::BORDER_REFLECT);
  cv::Mat dense = share >= kWhiteShare;
  cv::dilate(dense, dense, cv::getStructuringElement(cv::MORPH_RECT, window));
  return dense;
}

/// Parts of `set` that are connected to `seeds`.
cv::Mat connected_to(const cv::Mat& seeds, const cv::Mat& set) {
  cv::Mat labels;
  const int count = cv::connectedComponents(set, labels, 8, CV_32S);
  std::vector<char> has_seed(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < set.rows; ++y) {
    for (int x = 0; x < set.cols; ++x) {
      if (seeds.at<std::uint8_t>(y, x) != 0) has_seed[static_cast<std::size_t>(labels.at<int>(y, x))] = 1;
    }
  }
  has_seed[0] = 0;
  cv::Mat result = cv::Mat::zeros(set.size(), CV_8U);
  for (int y = 0; y < set.rows; ++y) {
    for (int x = 0; x < set.cols; ++x) {
      if (has_seed[static_cast<std::size_t>(labels.at<int>(y, x))] != 0) result.at<std::uint8_t>(y, x) = 255;
    }
  }
  return result;
}

/// `set` without its connected parts that reach into a wide area.
cv::Mat narrow_parts(const cv::Mat& set, int radius) {
  const cv::Mat wide = connected_to(wide_areas(set, radius) & set, set);
  return set & ~wide & ~wide_areas(set, radius);
}

cv::Mat disk(int radius) { return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}); }

/// Separable, so that its cost does not rise with the square of the radius.
cv::Mat square(int radius) { return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}); }

/// What lies below every bright thing that is narrower than the square.
cv::Mat ground_of(const cv::Mat& light, int radius) {
  cv::Mat ground;
  cv::morphologyEx(light, ground, cv::MORPH_OPEN, square(radius), {-1, -1}, 1, cv::BORDER_REFLECT);
  const int size = radius | 1;
  cv::blur(ground, ground, {size, size}, {-1, -1}, cv::BORDER_REFLECT);
  return cv::max(ground, static_cast<double>(kLeastGround));
}

/// What the first frames share: the least luminance, and the least darkest channel, of every pixel.
struct EarlyLook {
  cv::Mat light, darkest;
  int full_width = 0, full_height = 0;
};

EarlyLook look_at_start(int num_frames, const std::function<ImageF(int)>& read_frame, const RunControl& control) {
  EarlyLook look;
  const int span = std::min(num_frames, std::max(kLeastEarly, num_frames / kEarlyPart)),
            count = std::min(span, kMaxFrames);
  for (int k = 0; k < count; ++k) {
    control.throw_if_stopped();
    const ImageF frame = read_frame(count == 1 ? 0 : static_cast<int>(std::int64_t{k} * (span - 1) / (count - 1)));
    look.full_width = frame.width();
    look.full_height = frame.height();
    const double factor = std::min(1.0, static_cast<double>(kLookSide) / std::max(frame.width(), frame.height()));
    const int width = std::max(1, static_cast<int>(std::lround(frame.width() * factor)));
    const int height = std::max(1, static_cast<int>(std::lround(frame.height() * factor)));
    const ImageF low = downscale_area(frame, width, height);
    if (k == 0) look.light = look.darkest = cv::Mat();
    cv::Mat light(height, width, CV_32F), darkest(height, width, CV_32F);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto pixel = low.pixel(x, y);
        light.at<float>(y, x) = luminance(pixel);
        darkest.at<float>(y, x) = *std::min_element(pixel.begin(), pixel.end());
      }
    }
    look.light = k == 0 ? light : cv::Mat(cv::min(look.light, light));
    look.darkest = k == 0 ? darkest : cv::Mat(cv::min(look.darkest, darkest));
    control.report(0.9 * (k + 1) / count);
  }
  return look;
}

}  // namespace

void describe(OptionVisitor& v, HighlightOptions& o) {
  v.visit({"highlight_width",
           "Highlights are narrower than this share of the picture's shorter side; wider is white material", "",
           Range{.low = 0.0, .high = 1.0, .is_low_open = true}},
          o.width_share);
  v.visit({"highlight_extent", "A highlight reaches as far as it keeps so much of its height above the ground", "",
           between(0, 1)},
          o.extent);
  v.visit({"highlight_core", "A highlight's core is so many times as bright as the ground", "", above(1)}, o.core_rise);
}

ImageU8 find_saturated(const ImageF& photo, float level, const HighlightOptions& options) {
  check_ranges(options);
  ImageU8 result(photo.width(), photo.height());
  cv::Mat set(result.height(), result.width(), CV_8U, result.data());
  bool is_any = false;
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = 0; x < photo.width(); ++x) {
      const auto pixel = photo.pixel(x, y);
      if (!std::any_of(pixel.begin(), pixel.end(), [&](float v) { return v >= level; })) continue;
      result.at(x, y) = 255;
      is_any = true;
    }
  }
  if (!is_any) return result;
  const cv::Mat kept = narrow_parts(set, window_radius(photo.width(), photo.height(), options));
  // Light spills over from what is more than a speck.
  const cv::Mat block = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {2, 2});
  cv::Mat spots;
  cv::erode(kept, spots, square, {0, 0});
  cv::dilate(spots, spots, square, {1, 1});  // The other way, so that nothing moves.
  cv::dilate(spots, spots, block);
  cv::Mat(kept | spots).copyTo(set);
  return result;
}

ImageU8 find_standing_highlight(int num_frames, const std::function<ImageF(int)>& read_frame, float saturation,
                                const HighlightOptions& options, const RunControl& control) {
  check_ranges(options);
  if (num_frames < 1) throw InvalidInput("highlights: there are no frames");
  const EarlyLook look = look_at_start(num_frames, read_frame, control);
  const int radius = window_radius(look.light.cols, look.light.rows, options);
  const cv::Mat ground = ground_of(look.light, radius);
  const cv::Mat cores = narrow_parts(look.darkest >= static_cast<double>(kNearlySaturated * saturation), radius) &
                        (look.light >= options.core_rise * ground);
  const int core_radius =
      std::max(1, static_cast<int>(std::lround(0.5 * kLeastCore * std::min(cores.cols, cores.rows))));
  cv::Mat large_cores;
  cv::morphologyEx(cores, large_cores, cv::MORPH_OPEN, disk(core_radius));
  const cv::Mat seeds = connected_to(large_cores, cores);
  ImageU8 result(look.full_width, look.full_height);
  control.report(1.0);
  if (cv::countNonZero(seeds) == 0) return result;
  cv::Mat near, peak = cv::Mat::zeros(look.light.size(), CV_32F), highlight, large;
  cv::dilate(seeds, near, square(2 * radius));
  look.light.copyTo(peak, seeds);
  cv::dilate(peak, peak, square(2 * radius));
  const cv::Mat level = ground + options.extent * (peak - ground);
  highlight = connected_to(seeds, ((look.light >= level) & near) | seeds);
  cv::morphologyEx(highlight, highlight, cv::MORPH_CLOSE, disk(3));
  cv::dilate(highlight, highlight, disk(2));
  cv::resize(highlight, large, {look.full_width, look.full_height}, 0, 0, cv::INTER_NEAREST);
  for (int y = 0; y < look.full_height; ++y)
    std::copy_n(large.ptr<std::uint8_t>(y), look.full_width, result.row(y).begin());
  return result;
}

}  // namespace patinate::capture
