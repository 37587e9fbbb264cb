#include "capture/handheld/photo_features.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/alignment/clear_matches.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kMaxFeatures = 3000;           ///< See docs/algorithms/handheld.md.
constexpr float kRatio = 0.85f;              ///< Lowe's test: nearest over second nearest descriptor.
constexpr double kCodeOfDescriptor = 512.0;  ///< Square roots of shares lie in [0, 1], few above 0.5.

cv::Mat luminance_codes(const ImageF& color, double scale) {
  cv::Mat light(color.height(), color.width(), CV_32F);
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      const auto rgb = color.pixel(x, y);
      light.at<float>(y, x) = std::max(0.0f, 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]);
    }
  }
  if (scale < 1.0) {
    const cv::Size size(std::max(1, cvRound(light.cols * scale)), std::max(1, cvRound(light.rows * scale)));
    cv::resize(light, light, size, 0, 0, cv::INTER_AREA);
  }
  return light;
}

/// 128 = the local mean; 32 codes a local standard deviation.
cv::Mat evened(const cv::Mat& light) {
  constexpr double kFloor = 0.01;  // Share of the mean light: what is darker holds noise.
  cv::Mat log_light, mean, strength, codes;
  const double level = cv::mean(light)[0];
  cv::log(light + kFloor * level + 1e-9, log_light);
  const double window = 0.02 * std::max(light.cols, light.rows) + 4.0;
  cv::GaussianBlur(log_light, mean, {}, window);
  const cv::Mat detail = log_light - mean;
  cv::GaussianBlur(detail.mul(detail), strength, {}, window);
  cv::sqrt(strength, strength);
  constexpr double kMinStrength = 0.01;  // A plain background's noise is no detail.
  cv::divide(detail, strength + kMinStrength, codes, 32.0);
  codes.convertTo(codes, CV_8U, 1.0, 128.0);
  return codes;
}

cv::Mat detection_mask(const ImageU8& shown, const cv::Size& size) {
  if (shown.empty()) return {};
  const cv::Mat whole(shown.height(), shown.width(), CV_8U, const_cast<std::uint8_t*>(shown.data()));
  cv::Mat small;
  cv::resize(whole, small, size, 0, 0, cv::INTER_NEAREST);
  // The outline itself is no detail of the surface, and what lies beside it may differ.
  cv::erode(small, small, cv::getStructuringElement(cv::MORPH_RECT, {9, 9}), {-1, -1}, 1, cv::BORDER_CONSTANT, 255);
  return small;
}

ImageU8 as_image(const cv::Mat& codes) {
  ImageU8 image(codes.cols, codes.rows);
  for (int y = 0; y < codes.rows; ++y) std::copy_n(codes.ptr<std::uint8_t>(y), codes.cols, &image.at(0, y));
  return image;
}

cv::Mat descriptors_of(const PhotoFeatures& f) {
  const cv::Mat codes(static_cast<int>(f.points.size()), kFeatureNumbers, CV_8U,
                      const_cast<std::uint8_t*>(f.descriptors.data()));
  cv::Mat numbers;
  codes.convertTo(numbers, CV_32F);
  return numbers;
}

}  // namespace

PhotoFeatures find_features(const ImageF& color, const ImageU8& shown) {
  if (color.channels() != 3) throw InvalidInput("features: a photograph must have three channels");
  PhotoFeatures result;
  result.width = color.width();
  result.height = color.height();
  result.scale = std::min(1.0, static_cast<double>(kFeatureSide) / std::max(color.width(), color.height()));
  const cv::Mat codes = evened(luminance_codes(color, result.scale));
  const cv::Mat mask = detection_mask(shown, codes.size());
  result.evened = as_image(codes);
  if (!mask.empty()) result.shown = as_image(mask);
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  cv::SIFT::create(kMaxFeatures, 3, 0.02)->detectAndCompute(codes, mask, points, descriptors);
  const double sx = static_cast<double>(codes.cols) / color.width(),
               sy = static_cast<double>(codes.rows) / color.height();
  for (const cv::KeyPoint& p : points) {
    result.points.emplace_back((static_cast<double>(p.pt.x) + 0.5) / sx - 0.5,
                               (static_cast<double>(p.pt.y) + 0.5) / sy - 0.5);
  }
  result.descriptors.reserve(points.size() * kFeatureNumbers);
  for (int r = 0; r < descriptors.rows; ++r) {
    const cv::Mat row = descriptors.row(r);
    const double sum = std::max(1e-9, cv::sum(row)[0]);
    for (int c = 0; c < kFeatureNumbers; ++c) {
      const double root = std::sqrt(static_cast<double>(row.at<float>(0, c)) / sum);
      result.descriptors.push_back(
          static_cast<std::uint8_t>(std::min(255.0, std::floor(kCodeOfDescriptor * root + 0.5))));
    }
  }
  return result;
}

std::vector<std::pair<int, int>> match_features(const PhotoFeatures& a, const PhotoFeatures& b) {
  std::vector<std::pair<int, int>> matches;
  if (a.points.size() < 2 || b.points.size() < 2) return matches;
  const cv::Mat of_a = descriptors_of(a), of_b = descriptors_of(b);
  const std::vector<int> forth = clear_matches(of_a, of_b, kRatio), back = clear_matches(of_b, of_a, kRatio);
  for (std::size_t i = 0; i < forth.size(); ++i) {
    if (forth[i] >= 0 && back[forth[i]] == static_cast<int>(i)) matches.emplace_back(static_cast<int>(i), forth[i]);
  }
  return matches;
}

}  // namespace patinate::capture
