#include "analysis/figures/correspondence.h"

#include <algorithm>
#include <cmath>

#include "libcommon/image/filters.h"

namespace patinate::analysis {

namespace {

constexpr int kShifts = 8;         // Along a side.
constexpr double kLocal_px = 4.0;  // Sigma of the local mean.
constexpr double kMinTexels = 64;  ///< Fewer texels give no correlation.
constexpr int kMostSide = 256;     // Larger pictures are sampled at every so many pixels.

/// Lightness over its local mean; 0 outside the mask.
ImageF detail_of(const ColorStack& stack, std::size_t time, const ImageU8& mask) {
  ImageF detail = stack.lab_image(time, 0);
  const ImageF mean = gaussian_blur(detail, mask, kLocal_px, on_this_thread());
  for (std::int64_t i = 0; i < detail.num_pixels(); ++i) {
    float& v = detail.data()[i];
    v = mask.data()[i] != 0 ? v - mean.data()[i] : 0.0f;
  }
  return detail;
}

/// Correlation of A's pixels with B's that lie (dx, dy) further, around the ends; 0 where too few are of both.
double correlation_at(const ImageF& a, const ImageU8& mask_a, const ImageF& b, const ImageU8& mask_b, int dx, int dy) {
  const int width = a.width(), height = a.height();
  const int stride = std::max(1, std::max(width, height) / kMostSide);
  double n = 0.0, sa = 0.0, sb = 0.0, saa = 0.0, sbb = 0.0, sab = 0.0;
  for (int y = 0; y < height; y += stride) {
    for (int x = 0; x < width; x += stride) {
      const int bx = (x + dx) % width, by = (y + dy) % height;
      if (mask_a.at(x, y) == 0 || mask_b.at(bx, by) == 0) continue;
      const auto va = static_cast<double>(a.at(x, y)), vb = static_cast<double>(b.at(bx, by));
      n += 1.0, sa += va, sb += vb, saa += va * va, sbb += vb * vb, sab += va * vb;
    }
  }
  if (n < kMinTexels) return 0.0;
  const double va = saa / n - sa / n * sa / n, vb = sbb / n - sb / n * sb / n;
  constexpr double kFaint = 1e-6;  // L*^2.
  return va > kFaint && vb > kFaint ? (sab / n - sa / n * sb / n) / std::sqrt(va * vb) : 0.0;
}

SharedDetail shared_at(const ColorStack& a, const ColorStack& b, std::size_t time) {
  const ImageU8 mask_a = a.mask(), mask_b = b.mask();
  const ImageF detail_a = detail_of(a, time, mask_a);
  const ImageF detail_b = detail_of(b, time, mask_b);
  SharedDetail shared{.correlation = correlation_at(detail_a, mask_a, detail_b, mask_b, 0, 0), .by_chance = 0.0};
  for (int j = 0; j < kShifts; ++j) {
    for (int i = j == 0 ? 1 : 0; i < kShifts; ++i) {
      const double c =
          correlation_at(detail_a, mask_a, detail_b, mask_b, i * a.width / kShifts, j * a.height / kShifts);
      shared.by_chance = std::max(shared.by_chance, std::abs(c));
    }
  }
  return shared;
}

}  // namespace

SharedDetail shared_detail(const ColorStack& a, const ColorStack& b) {
  const SharedDetail first = shared_at(a, b, 0);
  if (first.is_clear() || a.num_times() < 2) return first;
  const SharedDetail last = shared_at(a, b, a.num_times() - 1);
  return last.is_clear() || last.correlation > first.correlation ? last : first;
}

bool have_same_charts(const ColorStack& a, const ColorStack& b) {
  const ImageU8 mask_a = a.mask(), mask_b = b.mask();
  std::int64_t num_both = 0, num_any = 0;
  int left = a.width, right = -1, top = a.height, bottom = -1;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const bool is_a = mask_a.at(x, y) != 0, is_b = mask_b.at(x, y) != 0;
      num_both += is_a && is_b ? 1 : 0;
      num_any += is_a || is_b ? 1 : 0;
      if (!is_a) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  if (right < 0) return false;
  const double rectangle = static_cast<double>(right - left + 1) * (bottom - top + 1);
  return static_cast<double>(num_both) >= 0.999 * static_cast<double>(num_any) &&
         static_cast<double>(num_both) < 0.98 * rectangle;
}

}  // namespace patinate::analysis
