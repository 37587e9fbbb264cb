#include "libcommon/atlas/dilate.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "libcommon/core/error.h"

namespace patinate {

namespace {

template <class T>
void fill_outside(Image<T>& image, const ImageU8& coverage, int radius) {
  const int w = image.width(), h = image.height();
  if (!image.same_size(coverage)) throw InvalidInput("dilate: image and coverage differ in size");
  // Nearest covered texel by two sweeps of propagated offsets [Danielsson 1980].
  constexpr int kFar = 1 << 14;
  struct Offset {
    int x, y;
    [[nodiscard]] std::int64_t squared() const { return std::int64_t{x} * x + std::int64_t{y} * y; }
  };
  Image<Offset> nearest(w, h, 1, Offset{kFar * 4, kFar * 4});
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      if (coverage.at(x, y) != 0) nearest.at(x, y) = {0, 0};
    }
  }
  const auto relax = [&](int x, int y, int dx, int dy) {
    if (!nearest.contains(x + dx, y + dy)) return;
    const Offset& from = nearest.at(x + dx, y + dy);
    const Offset candidate{from.x + dx, from.y + dy};
    if (candidate.squared() < nearest.at(x, y).squared()) nearest.at(x, y) = candidate;
  };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) relax(x, y, dx, dy);
    }
    for (int x = w - 1; x >= 0; --x) relax(x, y, 1, 0);
  }
  for (int y = h - 1; y >= 0; --y) {
    for (int x = w - 1; x >= 0; --x) {
      for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(x, y, dx, dy);
    }
    for (int x = 0; x < w; ++x) relax(x, y, -1, 0);
  }
  const std::int64_t limit = radius < 0 ? std::int64_t{kFar} * kFar : std::int64_t{radius} * radius;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const Offset& o = nearest.at(x, y);
      if (coverage.at(x, y) != 0 || o.squared() > limit || !coverage.contains(x + o.x, y + o.y)) continue;
      const auto from = image.pixel(x + o.x, y + o.y);
      std::copy(from.begin(), from.end(), image.pixel(x, y).begin());
    }
  }
}

}  // namespace

void dilate(ImageF& image, const ImageU8& coverage, int radius) { fill_outside(image, coverage, radius); }
void dilate(ImageU8& image, const ImageU8& coverage, int radius) { fill_outside(image, coverage, radius); }

}  // namespace patinate
