/// \file
/// What a border between two copied pieces costs, and what a texel's distance from its control does.
///
/// Neighbors p and q on the surface, q at e (in source pixels) from p, copy from s(p) and s(q):
///
///     V(p, q) = |F(s(p) + e) - F(s(q))| + |F(s(p)) - F(s(q) - e)|
///
/// with F the appearance and the structure of a pixel; 0 inside a piece. It is a metric of offsets, so that graph cuts
/// find the best border between two of them [Kwatra et al. 2003, "Graphcut textures"; Boykov, Veksler and Zabih 2001].
#pragma once

#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "patinate/image/image.h"
#include "transfer/synthesis/levels.h"
#include "transfer/synthesis/places.h"

namespace patinate::transfer {

/// Values that two pixels are compared by: as many small integers each. Differences squared sum up below 2^31.
class SeamFeatures {
 public:
  static constexpr int kSize = 16;                ///< kAppearanceSize of the appearance, the rest of the structure.
  static constexpr std::int32_t kOutside = 4096;  ///< Cost of a step to where nothing can be copied.

  /// @param structure  Of the level's size without its margin, up to 8 channels, in [0, 2]; empty: appearance alone.
  /// @param weight  What 1 of it counts, in units in which the appearance has a standard deviation of 170; [0, 1000].
  SeamFeatures(const SourceLevel& source, const ImageF& structure, double weight);

  /// |F(a) - F(b)|, rounded down; a correctly rounded square root, so the same everywhere.
  [[nodiscard]] std::int32_t distance(std::int32_t a, std::int32_t b) const;
  /// |F(a)|, squared: lines and unusual looks have much of it.
  [[nodiscard]] std::int32_t magnitude(std::int32_t a) const {
    const std::int16_t* p = values_.data() + std::int64_t{a} * kSize;
    return std::inner_product(p, p + kSize, p, std::int32_t{0});
  }
  /// V of places a (at p) and b (at q) with q at `step` from p, in p's frame.
  /// @param frame_turn  How far q's frame is turned in p's. Each piece goes by the step as it is turned itself.
  [[nodiscard]] std::int32_t seam(const Place& a, const Place& b, const FixedPoint& step, Turn frame_turn = 0) const;
  /// The pixel under a place; -1 where none can be copied.
  [[nodiscard]] std::int32_t pixel_at(std::int32_t x, std::int32_t y) const {
    const std::int32_t px = whole_pixels(x), py = whole_pixels(y);
    if (px < 0 || py < 0 || px >= width_ || py >= height_) return -1;
    const std::int32_t pixel = py * width_ + px;
    return source_.is_usable[pixel] != 0 ? pixel : -1;
  }

 private:
  [[nodiscard]] std::int32_t distance_or_outside(std::int32_t a, std::int32_t b) const {
    return a < 0 || b < 0 ? kOutside : distance(a, b);
  }

  const SourceLevel& source_;
  std::int32_t width_, height_;
  std::vector<std::int16_t> values_;  ///< kSize a pixel.
};

/// Cost of control mismatch for a texel, in units of V.
class ControlCost {
 public:
  /// @param weights  Of the controls; not negative. @param share  What a mismatch of the spread of a control costs,
  /// times 1/1000 of V's unit.
  ControlCost(const SourceLevel& source, std::span<const double> weights, double share);
  [[nodiscard]] std::int32_t at(std::span<const std::uint16_t> target, std::int32_t pixel) const {
    const auto n = target.size();
    const std::uint16_t* values = source_.controls.data() + static_cast<std::size_t>(pixel) * n;
    std::int32_t sum = 0;
    for (std::size_t c = 0; c < n; ++c) {
      const std::int32_t difference = values[c] - target[c];
      sum += table_[c * (kControlSteps + 1) + static_cast<std::size_t>(difference < 0 ? -difference : difference)];
    }
    return sum;
  }

 private:
  const SourceLevel& source_;
  std::vector<std::int32_t> table_;  ///< By control and difference.
};

}  // namespace patinate::transfer
