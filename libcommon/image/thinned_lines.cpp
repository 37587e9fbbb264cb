#include "libcommon/image/thinned_lines.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace patinate {

namespace {

struct LinePixel {
  int x = 0, y = 0;
};

}  // namespace

bool is_set(const ImageU8& image, int x, int y) { return image.contains(x, y) && image.at(x, y) != 0; }

std::array<bool, 8> set_neighbors(const ImageU8& image, int x, int y) {
  std::array<bool, 8> n{};
  for (std::size_t k = 0; k < 8; ++k) n[k] = is_set(image, x + kAroundX[k], y + kAroundY[k]);
  return n;
}

int num_branches(const std::array<bool, 8>& neighbors) {
  int count = 0;
  for (std::size_t k = 0; k < 8; ++k) count += !neighbors[k] && neighbors[(k + 1) % 8] ? 1 : 0;
  return count;
}

ImageU8 thinned(const ImageU8& mask) {
  ImageU8 lines(mask.width(), mask.height());
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) lines.data()[i] = mask.data()[i] != 0 ? 255 : 0;
  std::vector<LinePixel> left;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) != 0) left.push_back({x, y});
    }
  }
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const bool is_second : {false, true}) {
      std::vector<LinePixel> removed;
      for (const LinePixel& p : left) {
        const std::array<bool, 8> n = set_neighbors(lines, p.x, p.y);
        const auto count = std::count(n.begin(), n.end(), true);
        if (count < 2 || count > 6 || num_branches(n) != 1) continue;
        const bool keeps = is_second ? (n[0] && n[2] && n[6]) || (n[0] && n[4] && n[6])
                                     : (n[0] && n[2] && n[4]) || (n[2] && n[4] && n[6]);
        if (!keeps) removed.push_back(p);
      }
      for (const LinePixel& p : removed) lines.at(p.x, p.y) = 0;
      std::erase_if(left, [&](const LinePixel& p) { return lines.at(p.x, p.y) == 0; });
      is_changed = is_changed || !removed.empty();
    }
  }
  // Slanted lines leave stairs, two pixels a step: their corners are removed.
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) == 0) continue;
      const std::array<bool, 8> n = set_neighbors(lines, x, y);
      for (std::size_t k = 0; k < 8; k += 2) {
        if (n[k] && n[(k + 2) % 8] && !n[(k + 4) % 8] && !n[(k + 5) % 8] && !n[(k + 6) % 8]) lines.at(x, y) = 0;
      }
    }
  }
  return lines;
}

}  // namespace patinate
