#include "libcommon/output/picture_text.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace patinate {

namespace {

constexpr int kSupersampling = 4;

std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) out += c >= ' ' && c <= '~' ? c : '?';
  return out;
}

/// [0, 1] in a box.
cv::Mat text_opacity(const std::string& text, int width, int height, int letter_px, TextPlace place) {
  const int s = kSupersampling;
  cv::Mat large(height * s, width * s, CV_8U, cv::Scalar(0));
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  double scale = cv::getFontScaleFromHeight(kFont, letter_px * s, 1);
  int baseline = 0;
  cv::Size size = cv::getTextSize(text, kFont, scale, 1, &baseline);
  if (size.width > 0.96 * large.cols) {
    scale *= 0.96 * large.cols / size.width;
    size = cv::getTextSize(text, kFont, scale, 1, &baseline);
  }
  const int thickness = std::max(1, static_cast<int>(0.11 * size.height));
  const int free = large.cols - size.width;
  const int left = place == TextPlace::Left ? 0 : place == TextPlace::Right ? free : free / 2;
  cv::putText(large, text, {left, (large.rows + size.height) / 2}, kFont, scale, cv::Scalar(255), thickness,
              cv::LINE_8);
  cv::Mat small;
  cv::resize(large, small, {width, height}, 0, 0, cv::INTER_AREA);
  small.convertTo(small, CV_32F, 1.0 / 255.0);
  return small;
}

}  // namespace

void draw_text(ImageF& picture, const std::string& text, int x, int y, int width, int height, int letter_px, float ink,
               TextPlace place) {
  if (text.empty()) return;
  const cv::Mat opacity = text_opacity(printable(text), width, height, letter_px, place);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const float a = opacity.at<float>(row, column);
      for (float& value : picture.pixel(x + column, y + row)) value = (1.0f - a) * value + a * ink;
    }
  }
}

}  // namespace patinate
