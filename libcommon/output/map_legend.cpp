#include "libcommon/output/map_legend.h"

#include <algorithm>

#include "libcommon/core/text.h"
#include "libcommon/output/picture_text.h"

namespace patinate {

namespace {

constexpr int kMinWidth = 160, kMaxBar = 480;
constexpr int kGap_px = 6, kBar_px = 10, kLetter_px = 9, kLine_px = 18;
constexpr float kPaper = 0.92f, kInk = 0.03f;  // Gray values as contact_strip() has them.

std::string number_of(double value, const std::string& unit) {
  return short_number_text(rounded(value, 3)) + (unit.empty() ? "" : " " + unit);
}

}  // namespace

ImageF with_legend(const ImageF& picture, const MapLegend& legend) {
  const int width = std::max(picture.width(), kMinWidth), top = picture.height() + kGap_px;
  const int lines = legend.more.empty() ? 1 : 2;
  ImageF out(width, top + kBar_px + lines * kLine_px + kGap_px, 3, kPaper);
  const int shift = (width - picture.width()) / 2;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const auto from = picture.pixel(x, y);
      std::copy(from.begin(), from.end(), out.pixel(x + shift, y).begin());
    }
  }
  const int bar = std::min(width - 2 * kGap_px, kMaxBar), left = (width - bar) / 2;
  for (int x = 0; x < bar; ++x) {
    const std::array<float, 3> color = ramp_color(legend.ramp, static_cast<double>(x) / (bar - 1));
    for (int y = 0; y < kBar_px; ++y) std::copy(color.begin(), color.end(), out.pixel(left + x, top + y).begin());
  }
  const int line = top + kBar_px, third = bar / 3;
  draw_text(out, number_of(legend.low, legend.unit), left, line, third, kLine_px, kLetter_px, kInk, TextPlace::Left);
  draw_text(out, number_of((legend.low + legend.high) / 2.0, legend.unit), left + third, line, bar - 2 * third,
            kLine_px, kLetter_px, kInk, TextPlace::Middle);
  draw_text(out, number_of(legend.high, legend.unit), left + bar - third, line, third, kLine_px, kLetter_px, kInk,
            TextPlace::Right);
  draw_text(out, legend.more, kGap_px, line + kLine_px, width - 2 * kGap_px, kLine_px, kLetter_px, kInk);
  return out;
}

}  // namespace patinate
