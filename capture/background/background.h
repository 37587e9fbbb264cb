/// \file
/// What of a photograph is not the object: a plain background, a color, or what never changes.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/image/image.h"

namespace patinate::capture {

struct BackgroundOptions {
  std::string mask_background = "project";  ///< "off", "plain", "unchanging" or "#rrggbb"; "project": as that says.
};
void describe(OptionVisitor& v, BackgroundOptions& o);

struct BackgroundRule {
  enum class Kind { Off, Plain, Unchanging, Color };
  Kind kind = Kind::Off;
  std::array<float, 3> color{};  ///< Color of Color: sRGB codes, [0, 1].
};
inline constexpr std::string_view kBackgroundRules = "plain, unchanging, a color as #rrggbb, or off";
/// @throws InvalidInput that lists what there is.
[[nodiscard]] BackgroundRule background_rule(const std::string& text);

/// Longest side to which photographs are reduced for all of these. px.
inline constexpr int kBackgroundSide = 512;

/// A background of one color, with a slow course of its light: what is connected to the picture's border and no further
/// from a polynomial of second degree through the border than its own grain. Enclosed places of that color are the
/// object's: a white spot on a leaf that lies on white paper.
struct PlainBackground {
  ImageU8 mask;  ///< 255 = background. Nothing when the border is not plain.
  /// 255 = stands out clearly: further from the background's color than Otsu's threshold [Otsu 1979]. Without what the
  /// background's light and shadows make differ, with holes, and with spots of its color left out.
  ImageU8 clear;
  double border_share = 0.0;  ///< Part of the border that is of one color, [0, 1].
  [[nodiscard]] bool is_plain() const;
};
/// @param codes  H x W x 3, sRGB codes, [0, 1]. @param known  H x W, 0 = the photograph does not show it; may be empty.
[[nodiscard]] PlainBackground plain_background(const ImageF& codes, const ImageU8& known);

/// Whatever has the color, wherever it is: of a saturated color all shades between a third and one and a half of it,
/// of a gray what is within 0.1 (in sRGB codes, Euclidean).
[[nodiscard]] ImageU8 keyed_background(const ImageF& codes, const std::array<float, 3>& color);

/// Pixels that keep their color in all photographs to within noise and are connected to the border: the table, the
/// chart, the wall. Smoothed by 1.5 px first. @param photographs  sRGB codes of one size, two or more.
/// @throws InvalidInput with fewer.
[[nodiscard]] ImageU8 unchanging_background(const std::vector<ImageF>& photographs);

}  // namespace patinate::capture
