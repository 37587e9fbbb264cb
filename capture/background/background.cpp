#include "capture/background/background.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string_view>

#include "capture/stability/light_polynomial.h"
#include "libcommon/core/median.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr double kBorder = 0.03;    ///< Width of the border that is looked at, of the shorter side.
constexpr int kOrder = 2;           ///< Order of the light's course: a lamp's fall-off over a table.
constexpr double kGrains = 5.0;     ///< Standard deviations that a pixel of the background may lie off.
constexpr double kMinSpan = 0.03;   ///< Codes; eight of 255, what JPEG does to plain paper beside an edge.
constexpr double kMaxSpan = 0.12;   ///< A border that needs more is not plain.
constexpr double kPlain = 0.6;      ///< Part of the border, from which on it is: the object may be cut by one side.
constexpr double kSaturated = 0.3;  ///< (max - min) / max of a color that has shades.
/// Brightness of the background's color that still counts as background.
constexpr double kShadeLow = 1.0 / 3.0, kShadeHigh = 1.5;
constexpr double kNearColor = 0.1;     ///< Codes.
constexpr double kGrainBlur_px = 1.5;  ///< Takes a camera's grain to a fifth.
constexpr double kNoises =
    4.0;  ///< In standard deviations of a photograph's difference from the middle of all, in place.
constexpr double kSteady = 0.012;  ///< Codes; three of 255: less than this is no change.

float distance(const float* a, const std::array<double, 3>& b) {
  double sum = 0.0;
  for (std::size_t c = 0; c < 3; ++c) sum += (static_cast<double>(a[c]) - b[c]) * (static_cast<double>(a[c]) - b[c]);
  return static_cast<float>(std::sqrt(sum));
}

bool is_known(const ImageU8& known, std::int64_t i) { return known.empty() || known.data()[i] != 0; }

/// Pixels of `mask` that are connected to the picture's border, without threads of them that are a pixel wide: texture
/// of the object that happens to have the color.
ImageU8 connected_to_border(const ImageU8& mask) {
  cv::Mat open(mask.height(), mask.width(), CV_8U);
  std::copy(mask.values().begin(), mask.values().end(), open.data);
  cv::copyMakeBorder(open, open, 2, 2, 2, 2, cv::BORDER_REPLICATE);  // Opening shall not eat corners.
  cv::morphologyEx(open, open, cv::MORPH_OPEN, cv::Mat::ones(3, 3, CV_8U));
  open = open(cv::Rect(2, 2, mask.width(), mask.height())).clone();
  cv::Mat labels;
  cv::connectedComponents(open, labels, 4, CV_32S);
  std::set<int> at_border;
  for (int x = 0; x < labels.cols; ++x) at_border.insert({labels.at<int>(0, x), labels.at<int>(labels.rows - 1, x)});
  for (int y = 0; y < labels.rows; ++y) at_border.insert({labels.at<int>(y, 0), labels.at<int>(y, labels.cols - 1)});
  at_border.erase(0);
  ImageU8 result(mask.width(), mask.height());
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) result.at(x, y) = at_border.count(labels.at<int>(y, x)) != 0 ? 255 : 0;
  }
  return result;
}

/// The color of a plain background at every pixel.
class BackgroundColor {
 public:
  /// @param pixels  Where it is looked for; one or more.
  BackgroundColor(const ImageF& codes, const std::vector<std::int64_t>& pixels)
      : width_(codes.width()), height_(codes.height()) {
    std::vector<Eigen::VectorXd> terms;
    for (std::int64_t i : pixels) terms.push_back(terms_at(i));
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<double> values;
      for (std::int64_t i : pixels)
        values.push_back(static_cast<double>(codes.data()[3 * i + static_cast<std::int64_t>(c)]));
      coefficients_[c] = fit_polynomial(terms, values);
    }
  }

  [[nodiscard]] std::array<double, 3> at(std::int64_t pixel) const {
    const Eigen::VectorXd terms = terms_at(pixel);
    return {coefficients_[0].dot(terms), coefficients_[1].dot(terms), coefficients_[2].dot(terms)};
  }

 private:
  [[nodiscard]] Eigen::VectorXd terms_at(std::int64_t pixel) const {
    const double x = static_cast<double>(pixel % width_), y = static_cast<double>(pixel / width_);
    return monomials(2.0 * (x + 0.5) / width_ - 1.0, 2.0 * (y + 0.5) / height_ - 1.0, kOrder);
  }

  int width_, height_;
  std::array<Eigen::VectorXd, 3> coefficients_;
};

std::vector<std::int64_t> border_pixels(const ImageF& codes, const ImageU8& known) {
  const int w = codes.width(), h = codes.height();
  const int band = std::max(2, static_cast<int>(std::lround(kBorder * std::min(w, h))));
  std::vector<std::int64_t> pixels;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const bool is_border = x < band || y < band || x >= w - band || y >= h - band;
      const std::int64_t i = std::int64_t{y} * w + x;
      if (is_border && is_known(known, i)) pixels.push_back(i);
    }
  }
  return pixels;
}

/// Those within `span` of the commonest color of the border, channel by channel the middle one.
std::vector<std::int64_t> near_middle(const ImageF& codes, const std::vector<std::int64_t>& pixels, double span) {
  std::array<double, 3> middle{};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (std::int64_t i : pixels) values.push_back(codes.data()[3 * i + static_cast<std::int64_t>(c)]);
    middle[c] = static_cast<double>(median(std::move(values)));
  }
  std::vector<std::int64_t> near;
  for (std::int64_t i : pixels) {
    if (static_cast<double>(distance(codes.data() + 3 * i, middle)) < span) near.push_back(i);
  }
  return near;
}

}  // namespace

void describe(OptionVisitor& v, BackgroundOptions& o) {
  v.visit({"mask_background",
           "Mask the background: `plain` (one color around the object), `#rrggbb` (that color anywhere), `unchanging` "
           "(never changes in any photograph), `off`; `project`: as `background` of capture.json says, else off"},
          o.mask_background);
}

BackgroundRule background_rule(const std::string& text) {
  using Kind = BackgroundRule::Kind;
  if (text == "off") return {};
  if (text == "plain") return {.kind = Kind::Plain};
  if (text == "unchanging") return {.kind = Kind::Unchanging};
  constexpr std::string_view kDigits = "0123456789abcdefABCDEF";
  constexpr std::size_t kLength = 7;
  if (text.size() != kLength || text[0] != '#' || text.find_first_not_of(kDigits, 1) != std::string::npos) {
    throw InvalidInput("mask_background is `" + text + "`; give " + std::string(kBackgroundRules));
  }
  BackgroundRule rule{.kind = Kind::Color};
  for (std::size_t c = 0; c < 3; ++c)
    rule.color[c] = static_cast<float>(std::stoi(text.substr(1 + 2 * c, 2), nullptr, 16)) / 255.0f;
  return rule;
}

namespace {

ImageU8 clearly_different(const ImageF& codes, const ImageU8& known, const BackgroundColor& color, double span) {
  constexpr double kLargest = std::numbers::sqrt3;  // Distance between black and white, codes.
  cv::Mat1b far(codes.height(), codes.width(), std::uint8_t{0});
  for (std::int64_t i = 0; i < codes.num_pixels(); ++i) {
    if (is_known(known, i))
      far.data[i] = static_cast<std::uint8_t>(
          std::min(255.0, 255.0 / kLargest * static_cast<double>(distance(codes.data() + 3 * i, color.at(i)))));
  }
  cv::Mat1b parts;
  const double otsu = cv::threshold(far, parts, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  if (otsu < 255.0 / kLargest * span) cv::threshold(far, parts, 255.0 / kLargest * span, 255, cv::THRESH_BINARY);
  ImageU8 clear(codes.width(), codes.height());
  std::copy(parts.begin(), parts.end(), clear.values().begin());
  return clear;
}

}  // namespace

bool PlainBackground::is_plain() const { return border_share >= kPlain; }

PlainBackground plain_background(const ImageF& codes, const ImageU8& known) {
  PlainBackground result{ImageU8(codes.width(), codes.height()), {}};
  const std::vector<std::int64_t> border = border_pixels(codes, known);
  if (border.empty()) return result;
  // A course of the light along the border is allowed for before it is known: three times what a pixel may lie off.
  const std::vector<std::int64_t> near = near_middle(codes, border, 3.0 * kMaxSpan);
  if (near.empty()) return result;
  const BackgroundColor color(codes, near);
  std::vector<float> distances;
  for (std::int64_t i : border) distances.push_back(distance(codes.data() + 3 * i, color.at(i)));
  // The lower half is background in any case; its spread is the grain's. 1.54 = the middle of the length of three
  // normal numbers.
  const double grain = static_cast<double>(value_at_rank(distances, distances.size() / 2)) / 1.54;
  const double span = std::clamp(kGrains * grain, kMinSpan, kMaxSpan);
  const auto num_near =
      std::count_if(distances.begin(), distances.end(), [span](float d) { return static_cast<double>(d) <= span; });
  result.border_share = static_cast<double>(num_near) / static_cast<double>(border.size());
  if (!result.is_plain()) return result;
  ImageU8 alike(codes.width(), codes.height());
  for (std::int64_t i = 0; i < alike.num_pixels(); ++i) {
    // Unknown pixels connect: they lie at the border itself, beside the background.
    const bool is_alike =
        !is_known(known, i) || static_cast<double>(distance(codes.data() + 3 * i, color.at(i))) <= span;
    alike.data()[i] = is_alike ? 255 : 0;
  }
  result.mask = connected_to_border(alike);
  result.clear = clearly_different(codes, known, color, span);
  return result;
}

ImageU8 keyed_background(const ImageF& codes, const std::array<float, 3>& color) {
  const auto [low, high] = std::minmax_element(color.begin(), color.end());
  const bool has_shades = static_cast<double>(*high - *low) > kSaturated * static_cast<double>(*high);
  double length = 0.0;
  for (float v : color) length += static_cast<double>(v * v);
  ImageU8 result(codes.width(), codes.height());
  for (std::int64_t i = 0; i < result.num_pixels(); ++i) {
    const float* pixel = codes.data() + 3 * i;
    double shade = 1.0;
    if (has_shades) {
      double along = 0.0;
      for (std::size_t c = 0; c < 3; ++c) along += static_cast<double>(pixel[c] * color[c]);
      shade = std::clamp(along / length, kShadeLow, kShadeHigh);
    }
    std::array<double, 3> nearest{};
    for (std::size_t c = 0; c < 3; ++c) nearest[c] = shade * static_cast<double>(color[c]);
    result.data()[i] = static_cast<double>(distance(pixel, nearest)) <= kNearColor ? 255 : 0;
  }
  return result;
}

ImageU8 unchanging_background(const std::vector<ImageF>& photographs) {
  if (photographs.size() < 2) throw InvalidInput("mask_background: one photograph alone does not show what changes");
  std::vector<ImageF> codes;
  for (const ImageF& photograph : photographs) codes.push_back(gaussian_blur(photograph, kGrainBlur_px));
  const ImageF& first = codes.front();
  std::vector<std::array<double, 3>> middle(static_cast<std::size_t>(first.num_pixels()));
  for (std::int64_t i = 0; i < first.num_pixels(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<float> course;
      for (const ImageF& frame : codes) course.push_back(frame.data()[3 * i + static_cast<std::int64_t>(c)]);
      middle[i][c] = static_cast<double>(median(std::move(course)));
    }
  }
  // Noise in place is what neighbors in time differ by in the middle: most of the time most surfaces do not change.
  ImageU8 alike(first.width(), first.height());
  for (std::int64_t i = 0; i < first.num_pixels(); ++i) {
    std::vector<float> steps;
    float largest = 0.0f;
    for (std::size_t k = 0; k < codes.size(); ++k) {
      const float* now = codes[k].data() + 3 * i;
      largest = std::max(largest, distance(now, middle[i]));
      if (k == 0) continue;
      const float* before = codes[k - 1].data() + 3 * i;
      steps.push_back(distance(
          now, {static_cast<double>(before[0]), static_cast<double>(before[1]), static_cast<double>(before[2])}));
    }
    const double noise = static_cast<double>(median(std::move(steps))) / (1.54 * std::sqrt(2.0));
    alike.data()[i] = static_cast<double>(largest) <= std::max(kSteady, kNoises * std::min(noise, kSteady)) ? 255 : 0;
  }
  return connected_to_border(alike);
}

}  // namespace patinate::capture
