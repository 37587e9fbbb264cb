/// \file
/// Color of parts of a surface as numbers: what a curve over time is made of.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "patinate/image/image.h"

namespace patinate {

/// CIELAB (L* in [0, 100], a*, b*) of a linear Rec.709 color whose white is D65 [CIE 15:2004, sec. 8.2.1]. Negative
/// values are 0.
[[nodiscard]] std::array<double, 3> lab_from_linear(double red, double green, double blue);

/// Mean and percentiles of one channel.
struct ChannelSummary {
  double mean = 0.0;
  double p05 = 0.0;
  double p50 = 0.0;
  double p95 = 0.0;
};

/// Linear R, G, B, then L*, a*, b*; percentiles are those of each channel by itself.
struct ColorSummary {
  std::int64_t num_pixels = 0;
  std::array<ChannelSummary, 6> channels;
};

/// @param image   H x W x 3, linear.
/// @param pixels  Indices y * width + x; one that occurs twice counts twice. Percentiles are values that occur (nearest
/// rank).
/// @throws InvalidInput if the image has not 3 channels or an index lies outside; num_pixels is 0, and nothing else
/// set, for none.
[[nodiscard]] ColorSummary summarize_color(const ImageF& image, std::span<const std::uint32_t> pixels);

/// CIE 1976 difference of the mean colors: the distance in L*, a*, b*. About 2.3 is just noticeable.
[[nodiscard]] double delta_e(const ColorSummary& a, const ColorSummary& b);

}  // namespace patinate
