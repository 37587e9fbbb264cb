#include "libcommon/controls/image_control.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/error.h"

namespace patinate {

namespace {

/// Bilinear value at pixel coordinates; the border is repeated.
float sample(const ImageF& image, double x, double y) {
  const double cx = std::clamp(x, 0.0, image.width() - 1.0), cy = std::clamp(y, 0.0, image.height() - 1.0);
  const int x0 = static_cast<int>(cx), y0 = static_cast<int>(cy);
  const int x1 = std::min(x0 + 1, image.width() - 1), y1 = std::min(y0 + 1, image.height() - 1);
  const auto fx = static_cast<float>(cx - x0), fy = static_cast<float>(cy - y0);
  const float top = (1 - fx) * image.at(x0, y0) + fx * image.at(x1, y0);
  const float bottom = (1 - fx) * image.at(x0, y1) + fx * image.at(x1, y1);
  return (1 - fy) * top + fy * bottom;
}

}  // namespace

ControlMap image_map(const TexelMap& map, const ImageF& image) {
  if (image.empty() || image.channels() != 1) throw InvalidInput("image control: an image of one channel is needed");
  const auto values = image.values();
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) {
    throw InvalidInput("image control: the image holds NaN or infinity");
  }
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  ValueRange range;
  if (*least < 0.0F || *greatest > 1.0F) {
    range = {static_cast<double>(*least), static_cast<double>(*greatest)};
    if (!(range.high > range.low)) range.high = range.low + 1.0;
  }
  ImageF laid = image;
  if (image.width() != map.width() || image.height() != map.height()) {
    laid = ImageF(map.width(), map.height());
    const double sx = static_cast<double>(image.width()) / map.width(),
                 sy = static_cast<double>(image.height()) / map.height();
    for (int y = 0; y < map.height(); ++y) {
      for (int x = 0; x < map.width(); ++x) laid.at(x, y) = sample(image, (x + 0.5) * sx - 0.5, (y + 0.5) * sy - 0.5);
    }
  }
  return normalized_control(laid, map, range, "relative");
}

}  // namespace patinate
