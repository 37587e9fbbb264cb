#include "capture/project/plain_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "capture/background/background.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"
#include "patinate/image/image_io.h"

namespace patinate::capture {

namespace fs = std::filesystem;

namespace {

/// Part of the picture: less may be a stain, a scribe or a scratch on a sample that fills the picture.
constexpr double kMinObject = 0.1;
constexpr double kMaxObject = 0.9;  ///< Part of the picture: so little background does not matter.
/// Part of what is not background that is connected: spots on a sample are many. The grain of a wooden table is up to
/// a sixth (plates that were photographed by hand, docs/algorithms/grading.md).
constexpr double kMinWhole = 0.8;
constexpr double kBandContact = 0.5;  ///< Of a band's mean width: it ends at both borders with about all of that.
constexpr double kSameColor = 0.15;   ///< sRGB codes over their mean: what the white balance of a camera varies by.
/// Intersection over union of an object that stayed. An outline that is one pixel of 512 off takes about 2 % of an
/// object as large as kMinObject.
constexpr double kSamePlace = 0.95;

bool is_cut_out(const fs::path& photograph) {
  if (!probe_image(photograph).has_alpha()) return false;
  const ImageF alpha = read_gray(photograph, "A");
  return std::any_of(alpha.values().begin(), alpha.values().end(), [](float v) { return v < 1.0F; });
}

struct SeenObject {
  cv::Mat1b mask;  ///< 255 = object.
  double share = 0.0;
  std::array<double, 3> background{};  ///< Mean color, sRGB codes.
};

/// The one large part of what is not background; nothing where it is not one, or not large.
std::optional<SeenObject> seen_object(const fs::path& photograph) {
  const ImageF light = read_color(photograph);
  const double factor = std::min(1.0, static_cast<double>(kBackgroundSide) / std::max(light.width(), light.height()));
  const auto reduced = [factor](int side) { return std::max(1, static_cast<int>(std::lround(factor * side))); };
  ImageF codes = downscale_area(light, reduced(light.width()), reduced(light.height()));
  std::transform(codes.values().begin(), codes.values().end(), codes.values().begin(), srgb_from_linear);
  const PlainBackground plain = plain_background(codes, {});
  if (!plain.is_plain()) return std::nullopt;

  SeenObject seen;
  cv::Mat1b other(codes.height(), codes.width());
  double num_background = 0.0;
  for (std::int64_t i = 0; i < codes.num_pixels(); ++i) {
    const bool is_background = plain.mask.data()[i] != 0;
    other.data[i] = is_background ? 0 : 255;
    if (!is_background) continue;
    num_background += 1.0;
    for (std::size_t c = 0; c < 3; ++c)
      seen.background[c] += static_cast<double>(codes.data()[3 * i + static_cast<std::int64_t>(c)]);
  }
  for (double& value : seen.background) value /= std::max(1.0, num_background);

  cv::Mat labels, figures, centers;
  const int num_parts = cv::connectedComponentsWithStats(other, labels, figures, centers);
  int largest = 0;
  for (int k = 1; k < num_parts; ++k) {
    if (largest == 0 || figures.at<int>(k, cv::CC_STAT_AREA) > figures.at<int>(largest, cv::CC_STAT_AREA)) largest = k;
  }
  if (largest == 0) return std::nullopt;
  const double area = figures.at<int>(largest, cv::CC_STAT_AREA);
  seen.mask = labels == largest;
  // A band across the picture belongs to a sample. A shadow or a corner that reaches the border is no band.
  const auto is_band = [&](const cv::Mat& one_side, const cv::Mat& opposite, int length) {
    return std::min(cv::countNonZero(one_side), cv::countNonZero(opposite)) >= kBandContact * area / length;
  };
  if (is_band(seen.mask.row(0), seen.mask.row(seen.mask.rows - 1), seen.mask.rows) ||
      is_band(seen.mask.col(0), seen.mask.col(seen.mask.cols - 1), seen.mask.cols))
    return std::nullopt;
  seen.share = area / static_cast<double>(codes.num_pixels());
  const bool is_whole = area >= kMinWhole * cv::countNonZero(other);
  if (!is_whole || seen.share < kMinObject || seen.share > kMaxObject) return std::nullopt;
  return seen;
}

/// Whatever the exposure.
bool is_same_color(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  const double mean_a = (a[0] + a[1] + a[2]) / 3.0, mean_b = (b[0] + b[1] + b[2]) / 3.0;
  if (mean_a <= 0.0 || mean_b <= 0.0) return mean_a == mean_b;
  return std::hypot(a[0] / mean_a - b[0] / mean_b, a[1] / mean_a - b[1] / mean_b, a[2] / mean_a - b[2] / mean_b) <=
         kSameColor;
}

bool is_same_place(const cv::Mat1b& a, const cv::Mat1b& b) {
  if (a.size() != b.size()) return false;
  return cv::countNonZero(a & b) >= kSamePlace * cv::countNonZero(a | b);
}

}  // namespace

std::optional<PlainObject> find_plain_object(const std::vector<fs::path>& photographs) {
  if (photographs.empty()) return std::nullopt;
  std::optional<SeenObject> first;
  PlainObject object{.share = 1.0};
  for (const std::size_t k : {std::size_t{0}, photographs.size() / 2, photographs.size() - 1}) {
    std::optional<SeenObject> seen;
    try {
      if (is_cut_out(photographs[k])) return std::nullopt;
      seen = seen_object(photographs[k]);
    } catch (const IoError&) {
      return std::nullopt;  // `ingest` names the file.
    }
    if (!seen) return std::nullopt;
    if (!first) first = seen;
    if (!is_same_color(first->background, seen->background)) return std::nullopt;
    object.share = std::min(object.share, seen->share);
    object.has_moved = object.has_moved || !is_same_place(first->mask, seen->mask);
  }
  return object;
}

}  // namespace patinate::capture
