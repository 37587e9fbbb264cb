/// \file
/// Color: linear, Rec.709 / D65 primaries inside; sRGB transfer curve [IEC 61966-2-1] at the edges.
#pragma once

#include <cstdint>
#include <string>

#include "patinate/image/image.h"

namespace patinate {

/// sRGB code in [0, 1] to linear in [0, 1]. Values outside are extended by odd symmetry.
[[nodiscard]] float linear_from_srgb(float code);
[[nodiscard]] float srgb_from_linear(float linear);
/// 8-bit sRGB code of a linear value, clamped, rounded to nearest. Inverse of linear_from_srgb(code / 255) for all 256
/// codes.
[[nodiscard]] std::uint8_t srgb8_from_linear(float linear);

/// How integer codes of a photograph become linear values.
struct Response {
  /// File: as the file says, sRGB where it says nothing. The others hold whatever it says.
  enum class Kind { File, Srgb, Linear, Gamma };
  Kind kind = Kind::File;
  double gamma = 2.2;  ///< Only for Gamma; linear = code^gamma; > 0.

  /// @param code  in [0, 1]. File counts as Srgb.
  [[nodiscard]] float linear_from_code(float code) const;
  /// "as the file says", "srgb", "linear" or "gamma 2.2".
  [[nodiscard]] std::string text() const;
};

/// RGB (or gray) linear image as 8-bit sRGB, same channels.
[[nodiscard]] ImageU8 srgb8_from_linear(const ImageF& linear);
/// Rec.709 luminance of a pixel of an image with 1 or >= 3 channels, linear.
[[nodiscard]] float luminance(std::span<const float> pixel);

}  // namespace patinate
