/// \file
/// Values between the pixels of an image: Catmull and Rom's cubic over 4 x 4 pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate {

inline constexpr int kPixelSteps = 256;  ///< Places are known to as many parts of a pixel.

/// How far a place lies beside the middle of its pixel, in 1/256 pixel: [-128, 127].
struct BesidePixel {
  std::int8_t x = 0, y = 0;
  [[nodiscard]] bool is_middle() const { return x == 0 && y == 0; }
  friend bool operator==(const BesidePixel&, const BesidePixel&) = default;
};

namespace between_pixels {

/// A pixel's values.
using Lanes = float __attribute__((vector_size(16)));

/// Weights of the pixels -1, 0, 1 and 2 at t between 0 and 1. Quadrics are continued exactly, where weights of two
/// pixels flatten them by up to an eighth of their second difference.
constexpr std::array<double, 4> cubic_weights(double t) {
  return {t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (1.5 * t - 2.5), t * (0.5 + t * (2.0 - 1.5 * t)),
          0.5 * t * t * (t - 1.0)};
}
constexpr std::array<std::array<float, 4>, kPixelSteps> make_weights() {
  std::array<std::array<float, 4>, kPixelSteps> all{};
  for (int k = 0; k < kPixelSteps; ++k) {
    const std::array<double, 4> weights = cubic_weights(static_cast<double>(k) / kPixelSteps);
    for (std::size_t i = 0; i < weights.size(); ++i) all[k][i] = static_cast<float>(weights[i]);
  }
  return all;
}
inline constexpr std::array<std::array<float, 4>, kPixelSteps> kWeights = make_weights();

using Block = std::array<Lanes, 16>;  ///< 4 x 4 pixels around a place, row by row.

inline Lanes weighted(const Lanes* pixels, const std::array<float, 4>& w) {
  return w[0] * pixels[0] + w[1] * pixels[1] + w[2] * pixels[2] + w[3] * pixels[3];
}
inline Lanes least(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes greatest(Lanes a, Lanes b) { return a > b ? a : b; }

/// The value at a place, in the range of the block.
inline Lanes value_in(const Block& block, BesidePixel beside) {
  const auto& across = kWeights[beside.x & (kPixelSteps - 1)];
  const auto& down = kWeights[beside.y & (kPixelSteps - 1)];
  std::array<Lanes, 4> rows;
  Lanes low = block[0], high = block[0];
  for (std::size_t j = 0; j < 4; ++j) {
    const Lanes* const row = &block[4 * j];
    low = least(low, least(least(row[0], row[1]), least(row[2], row[3])));
    high = greatest(high, greatest(greatest(row[0], row[1]), greatest(row[2], row[3])));
    rows[j] = weighted(row, across);
  }
  return greatest(low, least(high, weighted(rows.data(), down)));
}

/// Calls visit(k, pixel index) for the 16 pixels around a place; those beyond the border are those at the border.
/// @param x,y  The pixel nearest to the place.
template <class Visit>
void for_each_around(int width, int height, int x, int y, BesidePixel beside, const Visit& visit) {
  const int x0 = x - (beside.x < 0 ? 2 : 1), y0 = y - (beside.y < 0 ? 2 : 1);
  for (int k = 0; k < 16; ++k) {
    const int column = std::clamp(x0 + k % 4, 0, width - 1), row = std::clamp(y0 + k / 4, 0, height - 1);
    visit(static_cast<std::size_t>(k),
          static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column));
  }
}

}  // namespace between_pixels

/// A place as the pixel nearest to it and how far beside its middle.
struct NearestPixel {
  int x, y;
  BesidePixel beside;
};
/// @param x,y  In pixels, whole numbers in the middles of pixels; at least 0.
[[nodiscard]] inline NearestPixel nearest_pixel(float x, float y) {
  const float column = std::floor(x + 0.5f), row = std::floor(y + 0.5f);
  const auto steps = [](float fraction) {
    return static_cast<std::int8_t>(std::clamp(std::lround(kPixelSteps * fraction), -128L, 127L));
  };
  return {static_cast<int>(column), static_cast<int>(row), {steps(x - column), steps(y - row)}};
}

/// The value of an image at a place. The curve goes through the pixels, so that the middle of a pixel has the pixel's
/// own value, and no value leaves the range of the 16 pixels. Those beyond the border are those at the border.
/// @tparam kChannels  1 to 4.
/// @param pixels  width * height * kChannels values. @param x,y  The pixel nearest to the place, inside the image.
/// @param value   kChannels values.
/// [Keys 1981, "Cubic convolution interpolation for digital image processing"; Catmull and Rom 1974]
template <std::size_t kChannels>
void look_between(const float* pixels, int width, int height, int x, int y, BesidePixel beside, float* value) {
  using namespace between_pixels;
  const int x0 = x - (beside.x < 0 ? 2 : 1), y0 = y - (beside.y < 0 ? 2 : 1);
  Block block;
  // Inside, four values are read of each pixel at once: where it has fewer, the others are not used, and must be there.
  if (x0 >= 0 && y0 >= 0 && x0 + 7 < width && y0 + 3 < height) {
    for (int k = 0; k < 16; ++k) {
      const auto pixel =
          static_cast<std::size_t>(y0 + k / 4) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x0 + k % 4);
      std::memcpy(&block[k], pixels + kChannels * pixel, sizeof(Lanes));
    }
  } else {
    for_each_around(width, height, x, y, beside, [&](std::size_t k, std::size_t pixel) {
      block[k] = Lanes{};
      std::memcpy(&block[k], pixels + kChannels * pixel, kChannels * sizeof(float));
    });
  }
  const Lanes result = value_in(block, beside);
  std::memcpy(value, &result, kChannels * sizeof(float));
}

/// Looks up one place. @param x,y  The place, inside the image.
template <std::size_t kChannels>
void look_at(const float* pixels, int width, int height, float x, float y, float* value) {
  const NearestPixel at = nearest_pixel(x, y);
  if (!at.beside.is_middle()) return look_between<kChannels>(pixels, width, height, at.x, at.y, at.beside, value);
  const auto pixel = static_cast<std::size_t>(at.y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(at.x);
  std::copy_n(pixels + kChannels * pixel, kChannels, value);
}

/// Looks up many places. @param source  1 to 4 channels. @param coordinates  H x W x 2: places inside it, or -1.
/// @returns H x W x channels; `outside` where coordinates are -1.
[[nodiscard]] ImageF look_up(const ImageF& source, const ImageF& coordinates, float outside = 0.0f,
                             const RunControl& control = {});

}  // namespace patinate
