/// \file
/// Areas as 64 samples a pixel: unions of shapes are exact where they overlap, and sums do not depend on an order.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::datasets {

/// A bit for each of 8 x 8 samples of a pixel; bit 8 j + i is sample (i, j), x right and y down.
using SampleImage = Image<std::uint64_t>;
inline constexpr int kSamplesPerSide = 8;
inline constexpr int kSamplesPerPixel = kSamplesPerSide * kSamplesPerSide;
/// How far samples lie from the center of their pixel, in pixels: at most 7/16 along x and along y.
inline constexpr double kSampleReach = 0.61872;

/// Where a sample column or row lies, in pixels from the picture's left or upper edge.
[[nodiscard]] inline double sample_place(int pixel, int sample) { return pixel + (sample + 0.5) / kSamplesPerSide; }

[[nodiscard]] inline int sample_count(std::uint64_t bits) {
  if (bits == 0) return 0;  // Most pixels have none or all of them, and the bits are counted without an instruction.
  return bits == ~std::uint64_t{0} ? kSamplesPerPixel : std::popcount(bits);
}
/// Share of the pixel, [0, 1].
[[nodiscard]] inline double sample_share(std::uint64_t bits) {
  return static_cast<double>(sample_count(bits)) / kSamplesPerPixel;
}

/// Pixels [x0, x1) x [y0, y1).
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// The pixels that touch a rectangle of the picture, cut to it. Places are in pixels from its upper left corner.
[[nodiscard]] PixelBox pixel_box(double left, double top, double right, double bottom, int width, int height);

/// Samples of a pixel at which `depth(x, y)` >= 0. @param depth  Of a place in pixels from the upper left corner.
/// @param slope  Bound of how steeply depth changes, per pixel. @param at_center  depth of the pixel's center.
template <class Depth>
[[nodiscard]] std::uint64_t samples_inside(int x, int y, double slope, double at_center, const Depth& depth) {
  if (at_center > slope * kSampleReach) return ~std::uint64_t{0};
  if (at_center < -slope * kSampleReach) return 0;
  std::uint64_t bits = 0;
  for (int j = 0; j < kSamplesPerSide; ++j) {
    for (int i = 0; i < kSamplesPerSide; ++i) {
      const bool is_inside = depth(sample_place(x, i), sample_place(y, j)) >= 0.0;
      bits |= static_cast<std::uint64_t>(is_inside) << (kSamplesPerSide * j + i);
    }
  }
  return bits;
}

/// Adds where `depth` >= 0 within the box to `out`; see samples_inside().
template <class Depth>
void cover(SampleImage& out, const PixelBox& box, double slope, const Depth& depth) {
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      std::uint64_t& bits = out.at(x, y);
      if (bits != ~std::uint64_t{0}) bits |= samples_inside(x, y, slope, depth(x + 0.5, y + 0.5), depth);
    }
  }
}

/// A rectangle of samples: those that lie at least so far from the picture's edges.
class SampleFrame {
 public:
  SampleFrame(int width, int height, double edge_px);
  /// Bits of the samples of a pixel inside.
  [[nodiscard]] std::uint64_t at(int x, int y) const {
    return columns_[static_cast<std::size_t>(x)] & rows_[static_cast<std::size_t>(y)];
  }
  [[nodiscard]] std::int64_t num_samples() const { return num_samples_; }

 private:
  std::vector<std::uint64_t> columns_, rows_;
  std::int64_t num_samples_ = 0;
};

[[nodiscard]] std::int64_t count_samples(const SampleImage& image);
[[nodiscard]] std::int64_t count_samples(const SampleImage& image, const SampleFrame& inside);
/// Shares of all pixels.
[[nodiscard]] ImageF sample_shares(const SampleImage& image);

}  // namespace patinate::datasets
