#include "analysis/cracks/line_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace patinate::analysis {

std::vector<std::vector<PixelPlace>> parts_of(const ImageU8& image, bool with_diagonals) {
  ImageU8 left = image;
  std::vector<std::vector<PixelPlace>> parts;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (left.at(x, y) == 0) continue;
      std::vector<PixelPlace> part{{x, y}};
      left.at(x, y) = 0;
      for (std::size_t i = 0; i < part.size(); ++i) {
        for (std::size_t k = 0; k < 8; k += with_diagonals ? 1 : 2) {
          const PixelPlace next{part[i].x + kAroundX[k], part[i].y + kAroundY[k]};
          if (!is_set(left, next.x, next.y)) continue;
          left.at(next.x, next.y) = 0;
          part.push_back(next);
        }
      }
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

double length_from(const ImageU8& lines, int x, int y) {
  const bool right = is_set(lines, x + 1, y), below = is_set(lines, x, y + 1);
  double length = 0.948 * (right + below);
  if (!right && !below && is_set(lines, x + 1, y + 1)) length += 1.340;
  if (is_set(lines, x - 1, y + 1) && !is_set(lines, x - 1, y) && !below) length += 1.340;
  return length;
}

std::vector<PixelPlace> junction_centers(const ImageU8& lines, double reach,
                                         std::vector<std::vector<PixelPlace>>& groups) {
  ImageU8 near(lines.width(), lines.height());
  std::vector<PixelPlace> pixels;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) != 0 && num_branches(set_neighbors(lines, x, y)) >= 3) pixels.push_back({x, y});
    }
  }
  std::vector<bool> is_taken(pixels.size());
  std::vector<PixelPlace> centers;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (is_taken[i]) continue;
    std::vector<PixelPlace> group{pixels[i]};
    is_taken[i] = true;
    for (std::size_t g = 0; g < group.size(); ++g) {
      // Pixels are in reading order: those near in y stand together.
      for (std::size_t j = i + 1; j < pixels.size() && pixels[j].y <= group[g].y + reach; ++j) {
        if (is_taken[j] || std::hypot(pixels[j].x - group[g].x, pixels[j].y - group[g].y) > reach) continue;
        is_taken[j] = true;
        group.push_back(pixels[j]);
      }
    }
    double sx = 0.0, sy = 0.0;
    for (const PixelPlace& p : group) sx += p.x, sy += p.y;
    const auto n = static_cast<double>(group.size());
    centers.push_back({static_cast<int>(std::lround(sx / n)), static_cast<int>(std::lround(sy / n))});
    groups.push_back(std::move(group));
  }
  return centers;
}

}  // namespace patinate::analysis
