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

constexpr double kWhiteShare = 0.6;   ///< Share of a window that is white material.
constexpr int kMaxLookedFrames = 16;  ///< Photographs that are looked at, evenly picked.
constexpr int kHighlightSide = 512;   ///< Pixels of the longer side at which the standing highlight is looked for.
constexpr int kMinEarly = 2;          ///< Least number of early photographs.
constexpr int kEarlyPart = 32;        ///< One in so many frames, the first ones: what grows is not there yet.
constexpr double kMinCore = 0.016;    ///< Share of the shorter side, across: wet grains glint in smaller spots.
constexpr int kMedianRadius = 16;     ///< Pixels of the thinned picture in which a median over a wide window is taken.
constexpr float kNearlySaturated =
    0.75f;  ///< Share of the saturated value, in the darkest channel: lossy files soften the plateau.
constexpr float kClipped = 0.93f;                              ///< Likewise, of what is surely clipped.
constexpr double kMostlyClipped = 0.5, kPartlyClipped = 0.01;  ///< Share of a core.
/// A sharp border blurs over a pixel or two. A skirt grows with its core: that of a Gaussian lobe, which would be 1.6
/// times the saturated value high, is 0.4 of the core's half width over a ground of a fifth of it.
constexpr double kMinSkirt_px = 3.0, kMinSkirt = 0.25;
constexpr double kExtentStep = 0.15;  ///< Steps of the required height (docs/algorithms/highlights.md).
/// Share of the saturated value. Specks beside what is so bright are its texture.
constexpr double kSameTexture = 1.0 / 1.3;
constexpr double kKnownWell = 0.93;    ///< Likewise: within 7 % of what is clipped.
constexpr float kSameMaterial = 0.5f;  ///< Likewise: what is darker is a crack or another material.
constexpr double kHereAndThere =
    0.15;                            ///< Share of the surroundings. The skirt of a lobe is so bright on half as much.
constexpr float kMinGround = 0.01f;  ///< Linear; darker surroundings count as this.

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
      if (seeds.at<std::uint8_t>(y, x) != 0) has_seed[labels.at<int>(y, x)] = 1;
    }
  }
  has_seed[0] = 0;
  cv::Mat result = cv::Mat::zeros(set.size(), CV_8U);
  for (int y = 0; y < set.rows; ++y) {
    for (int x = 0; x < set.cols; ++x) {
      if (has_seed[labels.at<int>(y, x)] != 0) result.at<std::uint8_t>(y, x) = 255;
    }
  }
  return result;
}

/// `set` without its connected parts that reach into a wide area.
cv::Mat narrow_parts(const cv::Mat& set, int radius) { return set & ~connected_to(wide_areas(set, radius) & set, set); }

/// Separable, so that its cost does not rise with the square of the radius.
cv::Mat square(int radius) { return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}); }

cv::Mat disk(int radius) { return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}); }

/// The middle value of the window around each pixel, from pixels of a coarse grid. @param values  [0, 1]; the result is
/// exact to 1/255 of their root.
cv::Mat usual_around(const cv::Mat& values, int radius) {
  const int step = std::max(1, radius / kMedianRadius), border = std::max(1, radius / step);
  cv::Mat thin, median;
  cv::resize(values, thin, {(values.cols + step - 1) / step, (values.rows + step - 1) / step}, 0, 0, cv::INTER_NEAREST);
  cv::sqrt(cv::max(thin, 0.0), thin);
  thin.convertTo(thin, CV_8U, 255.0);
  cv::copyMakeBorder(thin, thin, border, border, border, border, cv::BORDER_REFLECT);
  cv::medianBlur(thin, thin, 2 * border + 1);
  thin(cv::Rect(border, border, thin.cols - 2 * border, thin.rows - 2 * border)).convertTo(median, CV_32F, 1.0 / 255.0);
  cv::resize(median.mul(median), median, values.size(), 0, 0, cv::INTER_LINEAR);
  return median;
}

/// Usual light around each pixel: the median of a window twice as wide as a highlight may be, which therefore covers
/// less than half of it; so do cracks. Where all is brighter than that, as on the slope of a lamp's fall-off, what lies
/// below every bright thing that is narrower than a highlight.
cv::Mat ground_of(const cv::Mat& light, int radius, double saturation) {
  const cv::Mat usual = saturation * usual_around(light / saturation, 2 * radius);
  cv::Mat below;
  cv::morphologyEx(light, below, cv::MORPH_OPEN, square(radius), {-1, -1}, 1, cv::BORDER_REFLECT);
  const int size = radius | 1;
  cv::blur(below, below, {size, size}, {-1, -1}, cv::BORDER_REFLECT);
  return cv::max(cv::max(usual, below), static_cast<double>(kMinGround));
}

/// Whether the pixels at most `reach` away from the set are as bright as white material is of which parts are clipped:
/// usually so bright that specks would be its texture, and nearly saturated here and there. Without those that are too
/// dark to be the same (cracks, outlines) unless they are most.
bool is_in_white_material(const cv::Mat& set, const cv::Mat& values, int reach) {
  cv::Mat away;
  cv::distanceTransform(~set, away, cv::DIST_L2, 3);
  std::vector<float> all, same;
  for (int y = 0; y < set.rows; ++y) {
    for (int x = 0; x < set.cols; ++x) {
      const float d = away.at<float>(y, x), value = values.at<float>(y, x);
      if (!(d > 0.0f && d <= static_cast<float>(reach))) continue;
      all.push_back(value);
      if (value >= kSameMaterial) same.push_back(value);
    }
  }
  std::vector<float>& ring = 2 * same.size() > all.size() ? same : all;
  if (ring.empty()) return false;
  const auto part = [&](double share) {
    const auto at = ring.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(ring.size() - 1));
    std::nth_element(ring.begin(), at, ring.end());
    return static_cast<double>(*at);
  };
  return part(0.5) >= kSameTexture && part(1.0 - kHereAndThere) >= kKnownWell;
}

int core_radius(const cv::Size& size) {
  return std::max(1, static_cast<int>(std::lround(0.5 * kMinCore * std::min(size.width, size.height))));
}

/// The brightest channel over `level`, at most 1.
cv::Mat brightest_channel(const ImageF& photo, float level) {
  cv::Mat values(photo.height(), photo.width(), CV_32F);
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = 0; x < photo.width(); ++x) {
      const auto pixel = photo.pixel(x, y);
      values.at<float>(y, x) = std::clamp(*std::max_element(pixel.begin(), pixel.end()) / level, 0.0f, 1.0f);
    }
  }
  return values;
}

/// `found` without what is hardly brighter than the material around it: specks of a bright texture, and patches
/// with pixels about them which are nearly saturated as well.
cv::Mat without_white_material(const cv::Mat& found, const cv::Mat& values) {
  const int radius = core_radius(values.size());
  const cv::Mat usual = usual_around(values, 2 * radius);
  cv::Mat depth, labels, stats, centers;
  cv::distanceTransform(found, depth, cv::DIST_L2, 5);
  const cv::Mat patches = connected_to(depth > static_cast<double>(radius), found);
  cv::Mat result = found & ~patches & (usual < kSameTexture);
  const int count = cv::connectedComponentsWithStats(patches, labels, stats, centers, 8, CV_32S);
  for (int k = 1; k < count; ++k) {
    const double area = stats.at<int>(k, cv::CC_STAT_AREA);
    const int reach = std::max(4 * radius, static_cast<int>(std::sqrt(area / CV_PI)));
    const cv::Rect box(stats.at<int>(k, cv::CC_STAT_LEFT) - reach, stats.at<int>(k, cv::CC_STAT_TOP) - reach,
                       stats.at<int>(k, cv::CC_STAT_WIDTH) + 2 * reach,
                       stats.at<int>(k, cv::CC_STAT_HEIGHT) + 2 * reach);
    const cv::Rect part = box & cv::Rect(0, 0, values.cols, values.rows);
    const cv::Mat own = labels(part) == k;
    if (!is_in_white_material(own, values(part), reach)) result(part) |= own;
  }
  return result;
}

/// Light that the first frames share: the least luminance, and the least darkest channel, of every pixel.
struct EarlyLook {
  cv::Mat light, darkest;
  cv::Mat most;  ///< Largest value of the darkest channel; what trembles is clipped in some.
  int full_width = 0, full_height = 0;
};

EarlyLook look_at_start(int num_frames, const std::function<ImageF(int)>& read_frame, const RunControl& control) {
  EarlyLook look;
  const int span = std::min(num_frames, std::max(kMinEarly, num_frames / kEarlyPart)),
            count = std::min(span, kMaxLookedFrames);
  for (int k = 0; k < count; ++k) {
    control.throw_if_stopped();
    const ImageF frame = read_frame(count == 1 ? 0 : static_cast<int>(std::int64_t{k} * (span - 1) / (count - 1)));
    look.full_width = frame.width();
    look.full_height = frame.height();
    const double factor = std::min(1.0, static_cast<double>(kHighlightSide) / std::max(frame.width(), frame.height()));
    const int width = std::max(1, static_cast<int>(std::lround(frame.width() * factor)));
    const int height = std::max(1, static_cast<int>(std::lround(frame.height() * factor)));
    const ImageF low = downscale_area(frame, width, height);
    cv::Mat light(height, width, CV_32F), darkest(height, width, CV_32F);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto pixel = low.pixel(x, y);
        light.at<float>(y, x) = luminance(pixel);
        darkest.at<float>(y, x) = *std::min_element(pixel.begin(), pixel.end());
      }
    }
    look.light = k == 0 ? light : cv::Mat(cv::min(look.light, light));
    look.most = k == 0 ? darkest : cv::Mat(cv::max(look.most, darkest));
    look.darkest = k == 0 ? darkest : cv::Mat(cv::min(look.darkest, darkest));
    control.report(0.9 * (k + 1) / count);
  }
  return look;
}

/// Pixels connected to the seeds that keep `extent` of their height above the ground. What then reaches farther than
/// `farthest` is no skirt of a highlight but material: it is cut higher up.
cv::Mat reach_of(const cv::Mat& seeds, const cv::Mat& light, const cv::Mat& ground, int farthest, double extent) {
  double peak = 0.0;
  cv::minMaxLoc(light, nullptr, &peak, nullptr, nullptr, seeds);
  cv::Mat away, result = seeds.clone(), open = seeds.clone();
  cv::distanceTransform(~seeds, away, cv::DIST_L2, 5);
  const cv::Mat far = away > static_cast<double>(farthest);
  for (double share = extent; share < 1.0; share += kExtentStep) {
    const cv::Mat level = ground + share * (peak - ground);
    const cv::Mat grown = connected_to(open, (light >= level) | open);
    const cv::Mat too_far = connected_to(far & grown, grown);
    result |= grown & ~too_far;
    open &= too_far;
    if (cv::countNonZero(open) == 0) break;
  }
  return result;
}

/// Parts of `reach` (cores with their skirts) that a lamp made: the core is clipped, or partly clipped and with a
/// skirt. White paint on darker paint has sharp borders and is seldom clipped.
cv::Mat lamps_among(const cv::Mat& reach, const cv::Mat& cores, const cv::Mat& clipped) {
  struct Part {
    double area = 0.0, core = 0.0, border = 0.0, clipped = 0.0;
  };
  cv::Mat labels, inner;
  const int count = cv::connectedComponents(reach, labels, 8, CV_32S);
  cv::erode(cores, inner, cv::Mat());
  std::vector<Part> parts(static_cast<std::size_t>(count));
  for (int y = 0; y < reach.rows; ++y) {
    for (int x = 0; x < reach.cols; ++x) {
      Part& part = parts[labels.at<int>(y, x)];
      const bool is_core = cores.at<std::uint8_t>(y, x) != 0;
      part.area += 1.0;
      part.core += is_core ? 1.0 : 0.0;
      part.border += is_core && inner.at<std::uint8_t>(y, x) == 0 ? 1.0 : 0.0;
      part.clipped += is_core && clipped.at<std::uint8_t>(y, x) != 0 ? 1.0 : 0.0;
    }
  }
  cv::Mat result = cv::Mat::zeros(reach.size(), CV_8U);
  for (int k = 1; k < count; ++k) {
    const Part& part = parts[k];
    const double border = std::max(1.0, part.border), share = part.clipped / std::max(1.0, part.core);
    const double skirt = (part.area - part.core) / border, half_width = 2.0 * part.core / border;
    const bool has_skirt = skirt >= std::max(kMinSkirt_px, kMinSkirt * half_width);
    if (share >= kMostlyClipped || (share >= kPartlyClipped && has_skirt)) result.setTo(255, labels == k);
  }
  return result;
}

}  // namespace

void describe(OptionVisitor& v, HighlightOptions& o) {
  v.visit({"highlight_width",
           "Largest width of a highlight, as a share of the picture's shorter side; wider areas are white material", "",
           Range{.low = 0.0, .high = 1.0, .is_low_open = true}},
          o.width_share);
  v.visit({"highlight_extent",
           "A highlight extends until its height above the background falls below this share of its core's", "",
           between(0, 1)},
          o.extent);
  v.visit({"highlight_core", "Smallest ratio of a highlight's core to the background's brightness", "", above(1)},
          o.core_rise);
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
  const cv::Mat narrow = narrow_parts(set, window_radius(photo.width(), photo.height(), options));
  const cv::Mat kept = without_white_material(narrow, brightest_channel(photo, level));
  // Around spots that are larger than a speck, the neighboring pixels are masked, too: light spills over into them.
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
  const cv::Mat ground = ground_of(look.light, radius, static_cast<double>(saturation));
  const cv::Mat cores = narrow_parts(look.darkest >= static_cast<double>(kNearlySaturated * saturation), radius) &
                        (look.light >= options.core_rise * ground);
  cv::Mat large_cores;
  cv::morphologyEx(cores, large_cores, cv::MORPH_OPEN, disk(core_radius(cores.size())));
  const cv::Mat seeds = connected_to(large_cores, cores);
  ImageU8 result(look.full_width, look.full_height);
  control.report(1.0);
  if (cv::countNonZero(seeds) == 0) return result;
  const cv::Mat clipped = look.most >= static_cast<double>(kClipped * saturation);
  cv::Mat highlight = lamps_among(reach_of(seeds, look.light, ground, 2 * radius, options.extent), seeds, clipped);
  cv::Mat large;
  cv::morphologyEx(highlight, highlight, cv::MORPH_CLOSE, disk(3));
  cv::dilate(highlight, highlight, disk(2));
  cv::resize(highlight, large, {look.full_width, look.full_height}, 0, 0, cv::INTER_NEAREST);
  for (int y = 0; y < look.full_height; ++y)
    std::copy_n(large.ptr<std::uint8_t>(y), look.full_width, result.row(y).begin());
  return result;
}

}  // namespace patinate::capture
