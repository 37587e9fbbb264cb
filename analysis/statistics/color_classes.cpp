#include "analysis/statistics/color_classes.h"

#include <limits>

#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace {

/// -1 for what is no hexadecimal digit.
int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

ColorClass parse_color_class(const std::string& text) {
  const std::size_t at = text.find('=');
  const auto fail = [&] { throw InvalidInput("color class: found `" + text + "`; expected NAME=#RRGGBB"); };
  if (at == std::string::npos || at == 0 || text.size() != at + 8 || text[at + 1] != '#') fail();
  ColorClass c{text.substr(0, at)};
  for (std::size_t k = 0; k < 3; ++k) {
    const int high = digit_of(text[at + 2 + 2 * k]), low = digit_of(text[at + 3 + 2 * k]);
    if (high < 0 || low < 0) fail();
    c.code[k] = (16 * high + low) / 255.0;
  }
  return c;
}

std::vector<double> class_shares(const ImageF& rgb, const ImageU8& mask, const std::vector<ColorClass>& classes) {
  if (rgb.channels() != 3 || (!mask.empty() && !mask.same_size(rgb)))
    throw InvalidInput("color classes: three channels and a mask of their size are needed");
  if (classes.empty()) throw InvalidInput("color classes: there is none");
  std::vector<double> counts(classes.size());
  double total = 0.0;
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      std::array<double, 3> code{};
      for (std::size_t c = 0; c < 3; ++c) code[c] = static_cast<double>(srgb_from_linear(rgb.pixel(x, y)[c]));
      std::size_t nearest = 0;
      double least = std::numeric_limits<double>::max();
      for (std::size_t k = 0; k < classes.size(); ++k) {
        double d = 0.0;
        for (std::size_t c = 0; c < 3; ++c) d += (code[c] - classes[k].code[c]) * (code[c] - classes[k].code[c]);
        if (d < least) least = d, nearest = k;
      }
      counts[nearest] += 1.0;
      total += 1.0;
    }
  }
  if (total == 0.0) throw InvalidInput("color classes: the mask covers nothing");
  for (double& c : counts) c /= total;
  return counts;
}

}  // namespace patinate::analysis
