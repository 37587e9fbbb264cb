#include "patinate/atlas/dilate.h"

#include <algorithm>
#include <cstdint>

#include "libcommon/atlas/gutter_fill.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

template <class T>
void fill_outside(Image<T>& image, const ImageU8& coverage, int radius) {
  if (!image.same_size(coverage)) throw InvalidInput("dilate: image and coverage differ in size");
  if (image.num_pixels() >= std::int64_t{kNoValue}) throw InvalidInput("dilate: at most 2^32 - 2 texels");
  if (image.empty()) return;
  Image<std::uint32_t> nearest(image.width(), image.height(), 1, kNoValue);
  for (std::size_t i = 0; i < nearest.values().size(); ++i) {
    if (coverage.data()[i] != 0) nearest.data()[i] = static_cast<std::uint32_t>(i);
  }
  fill_gutters(nearest, {.on_progress = {}, .stop = {}, .num_threads = 1});
  const std::int64_t limit = std::int64_t{radius} * radius;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const std::uint32_t from = nearest.at(x, y);
      if (coverage.at(x, y) != 0 || from == kNoValue) continue;
      const int fx = static_cast<int>(from % static_cast<std::uint32_t>(image.width())),
                fy = static_cast<int>(from / static_cast<std::uint32_t>(image.width()));
      if (radius >= 0 && std::int64_t{fx - x} * (fx - x) + std::int64_t{fy - y} * (fy - y) > limit) continue;
      const auto pixel = image.pixel(fx, fy);
      std::copy(pixel.begin(), pixel.end(), image.pixel(x, y).begin());
    }
  }
}

}  // namespace

void dilate(ImageF& image, const ImageU8& coverage, int radius) { fill_outside(image, coverage, radius); }
void dilate(ImageU8& image, const ImageU8& coverage, int radius) { fill_outside(image, coverage, radius); }

}  // namespace patinate
