#include "libcommon/output/contact_strip.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr int kSupersampling = 4;

std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) out += c >= ' ' && c <= '~' ? c : '?';
  return out;
}

// Opacity of a line of text in a box, [0, 1], centered.
cv::Mat text_opacity(const std::string& text, int width, int height, int letter_px) {
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
  cv::putText(large, text, {(large.cols - size.width) / 2, (large.rows + size.height) / 2}, kFont, scale,
              cv::Scalar(255), thickness, cv::LINE_8);
  cv::Mat small;
  cv::resize(large, small, {width, height}, 0, 0, cv::INTER_AREA);
  small.convertTo(small, CV_32F, 1.0 / 255.0);
  return small;
}

}  // namespace

ImageF contact_strip(std::span<const ImageF> pictures, std::span<const std::string> labels,
                     const ContactStripOptions& options) {
  if (pictures.empty()) throw InvalidInput("contact strip: there is no picture");
  if (!labels.empty() && labels.size() != pictures.size()) {
    throw InvalidInput("contact strip: " + std::to_string(labels.size()) + " labels for " +
                       std::to_string(pictures.size()) + " pictures");
  }
  if (options.columns < 0 || options.gap_px < 0 || options.gap_px > 1000 || options.label_px < 0 ||
      options.label_px > 500) {
    throw InvalidInput("contact strip: columns, gap or label height is out of range");
  }
  const int w = pictures[0].width(), h = pictures[0].height();
  for (const ImageF& p : pictures) {
    if (p.width() != w || p.height() != h || p.empty() || (p.channels() != 1 && p.channels() != 3)) {
      throw InvalidInput("contact strip: pictures differ in size or have neither 1 nor 3 channels");
    }
  }
  const int count = static_cast<int>(pictures.size());
  const int columns = options.columns > 0 ? std::min(options.columns, count) : count;
  const int rows = (count + columns - 1) / columns;
  const int letter = labels.empty() ? 0 : options.label_px > 0 ? options.label_px : std::max(10, h / 26);
  const int label_height = labels.empty() ? 0 : 2 * letter;
  const int gap = options.gap_px;
  ImageF strip(columns * (w + gap) + gap, rows * (h + label_height + gap) + gap, 3, options.background);
  const float ink = options.background > 0.2f ? 0.03f : 0.85f;
  for (int i = 0; i < count; ++i) {
    const ImageF& picture = pictures[static_cast<std::size_t>(i)];
    const int x0 = gap + (i % columns) * (w + gap), y0 = gap + (i / columns) * (h + label_height + gap);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        for (int c = 0; c < 3; ++c) strip.at(x0 + x, y0 + y, c) = picture.at(x, y, picture.channels() == 3 ? c : 0);
      }
    }
    if (label_height == 0) continue;
    const cv::Mat opacity = text_opacity(printable(labels[static_cast<std::size_t>(i)]), w, label_height, letter);
    for (int y = 0; y < label_height; ++y) {
      for (int x = 0; x < w; ++x) {
        const float a = opacity.at<float>(y, x);
        for (int c = 0; c < 3; ++c) strip.at(x0 + x, y0 + h + y, c) = (1.0f - a) * options.background + a * ink;
      }
    }
  }
  return strip;
}

}  // namespace patinate
