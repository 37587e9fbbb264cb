#include "analysis/cracks/line_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace patinate::analysis {

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

ImageU8 thinned(const ImageU8& cracks) {
  ImageU8 lines(cracks.width(), cracks.height());
  for (std::int64_t i = 0; i < cracks.num_pixels(); ++i) lines.data()[i] = cracks.data()[i] != 0 ? 255 : 0;
  std::vector<PixelPlace> left;
  for (int y = 0; y < lines.height(); ++y) {
    for (int x = 0; x < lines.width(); ++x) {
      if (lines.at(x, y) != 0) left.push_back({x, y});
    }
  }
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (const bool is_second : {false, true}) {
      std::vector<PixelPlace> removed;
      for (const PixelPlace& p : left) {
        const std::array<bool, 8> n = set_neighbors(lines, p.x, p.y);
        const auto count = std::count(n.begin(), n.end(), true);
        if (count < 2 || count > 6 || num_branches(n) != 1) continue;
        const bool keeps = is_second ? (n[0] && n[2] && n[6]) || (n[0] && n[4] && n[6])
                                     : (n[0] && n[2] && n[4]) || (n[2] && n[4] && n[6]);
        if (!keeps) removed.push_back(p);
      }
      for (const PixelPlace& p : removed) lines.at(p.x, p.y) = 0;
      std::erase_if(left, [&](const PixelPlace& p) { return lines.at(p.x, p.y) == 0; });
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
