#include "libcommon/output/contact_strip.h"

#include <algorithm>

#include "libcommon/output/picture_text.h"
#include "patinate/core/error.h"

namespace patinate {

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
    const ImageF& picture = pictures[i];
    const int x0 = gap + (i % columns) * (w + gap), y0 = gap + (i / columns) * (h + label_height + gap);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        for (int c = 0; c < 3; ++c) strip.at(x0 + x, y0 + y, c) = picture.at(x, y, picture.channels() == 3 ? c : 0);
      }
    }
    if (label_height == 0) continue;
    draw_text(strip, labels[i], x0, y0 + h, w, label_height, letter, ink);
  }
  return strip;
}

}  // namespace patinate
