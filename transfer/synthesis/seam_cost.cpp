#include "transfer/synthesis/seam_cost.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace patinate::transfer {

SeamFeatures::SeamFeatures(const SourceLevel& source, const ImageF& structure, double weight)
    : source_(source),
      width_(source.width()),
      height_(source.height()),
      values_(static_cast<std::size_t>(source.appearance.num_pixels()) * kSize, 0) {
  for (std::int32_t y = 0; y < source.height(); ++y) {
    for (std::int32_t x = 0; x < width_; ++x) {
      const std::int64_t p = std::int64_t{y} * width_ + x;
      std::int16_t* out = values_.data() + p * kSize;
      std::copy_n(source.appearance.data() + p * kAppearanceSize, kAppearanceSize, out);
      const int sx = x - source.margin_px, sy = y - source.margin_px;
      if (!structure.contains(sx, sy)) continue;
      for (int c = 0; c < structure.channels(); ++c) {
        const double value = static_cast<double>(structure.at(sx, sy, c)) * weight;
        out[kAppearanceSize + c] = static_cast<std::int16_t>(std::floor(value + 0.5));
      }
    }
  }
}

std::int32_t SeamFeatures::distance(std::int32_t a, std::int32_t b) const {
  const std::int16_t *p = values_.data() + std::int64_t{a} * kSize, *q = values_.data() + std::int64_t{b} * kSize;
#if defined(__SSE2__)
  const auto load = [](const std::int16_t* at) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at)); };
  const __m128i low = _mm_sub_epi16(load(p), load(q)), high = _mm_sub_epi16(load(p + 8), load(q + 8));
  __m128i sum = _mm_add_epi32(_mm_madd_epi16(low, low), _mm_madd_epi16(high, high));
  sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0x4E));
  sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xB1));
  const std::int32_t squared = _mm_cvtsi128_si32(sum);
#else
  std::int32_t squared = 0;
  for (int k = 0; k < kSize; ++k) squared += (p[k] - q[k]) * (p[k] - q[k]);
#endif
  return static_cast<std::int32_t>(std::sqrt(static_cast<float>(squared)));
}

std::int32_t SeamFeatures::seam(const Place& first, const Place& second, const FixedPoint& step,
                                Turn frame_turn) const {
  const FixedPoint &a = first.point, &b = second.point, by_first = turned(step, first.turn),
                   by_second = turned(step, difference_of(second.turn, frame_turn));
  const std::int32_t ax = a.x + by_first.x, ay = a.y + by_first.y;
  constexpr std::int32_t kSamePiece = PixelNeighbor::kOne / 2;  // Steps and places are rounded.
  if (std::abs(ax - b.x) <= kSamePiece && std::abs(ay - b.y) <= kSamePiece) return 0;
  return distance_or_outside(pixel_at(ax, ay), pixel_at(b.x, b.y)) +
         distance_or_outside(pixel_at(a.x, a.y), pixel_at(b.x - by_second.x, b.y - by_second.y));
}

ControlCost::ControlCost(const SourceLevel& source, std::span<const double> weights, double share) : source_(source) {
  double total = 0.0;
  for (double w : weights) total += w;
  constexpr double kFree = 0.01 * kControlSteps;  // Difference that is not visible.
  for (std::size_t c = 0; c < weights.size(); ++c) {
    for (int d = 0; d <= kControlSteps; ++d) {
      const double difference = std::max(0.0, d - kFree);
      const double cost =
          total > 0.0 ? 1000.0 * share * weights[c] / total * difference * difference / source.control_variances[c]
                      : 0.0;
      table_.push_back(static_cast<std::int32_t>(std::min(cost, 1e6)));
    }
  }
}

}  // namespace patinate::transfer
