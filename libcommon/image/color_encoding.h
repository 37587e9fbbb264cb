/// \file
/// Colors of files that say something other than sRGB codes or linear Rec. 709 values, and the way from them to linear
/// Rec. 709. Inside of image input only.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "patinate/image/image.h"

namespace patinate {

/// How the color of a picture becomes linear light with Rec. 709 primaries and D65. Thread-safe.
class ColorEncoding {
 public:
  virtual ~ColorEncoding() = default;
  /// @param rgb  3 channels: codes in [0, 1], or a float file's values. In place; what lies outside of Rec. 709
  /// becomes negative or more than 1.
  virtual void to_linear(ImageF& rgb) const = 0;
};

/// CIE xy of red, green, blue and white.
struct Chromaticities {
  std::array<std::array<double, 2>, 4> xy{};
};
inline constexpr Chromaticities kRec709{{{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}}}};
/// "BT.2020", or "primaries" for those that have no name here; to three digits.
[[nodiscard]] std::string primaries_name(const Chromaticities& primaries);
inline constexpr Chromaticities kAdobeRgb{{{{0.64, 0.33}, {0.21, 0.71}, {0.15, 0.06}, {0.3127, 0.3290}}}};

/// Color that a file states, as understood.
struct SaidColor {
  std::string name;  ///< "Display P3 (ICC profile)"; "" = it says nothing that can be used.
  /// Nothing: what values are anyway, sRGB codes or linear Rec. 709.
  std::shared_ptr<const ColorEncoding> encoding = {};
  std::string problem = {};  ///< Statement that is not used, and why.
};

/// linear = code^gamma with `primaries`; white is adapted by Bradford's matrix [Lam1985].
/// @param name  Of the result. Its problem says where primaries make no color space.
[[nodiscard]] SaidColor color_of_primaries(std::string name, const Chromaticities& primaries, double gamma);
/// Color of codes of the sRGB curve.
[[nodiscard]] SaidColor srgb_color_of_primaries(std::string name, const Chromaticities& primaries);
/// Color of values that are light.
[[nodiscard]] SaidColor light_of_primaries(std::string name, const Chromaticities& primaries);
/// Code points of ITU-T H.273, as PNG's cICP and HEIF's nclx have them. Light of PQ and HLG is 1 at reference white
/// [ITU-R BT.2408: 203 cd/m2, 75 % of HLG].
[[nodiscard]] SaidColor color_of_code_points(int primaries, int transfer, bool is_full_range);
/// An embedded ICC profile, relative colorimetric. @param channels  Of the picture: 1, 3, or 4 for CMYK.
[[nodiscard]] SaidColor color_of_profile(const std::string& bytes, int channels);

/// A profile's way from shares of ink, CMYK, to linear Rec. 709. Thread-safe.
class InkEncoding {
 public:
  virtual ~InkEncoding() = default;
  /// @param cmyk  4 channels in [0, 1]; 1 = all ink. @returns 3 channels.
  [[nodiscard]] virtual ImageF to_linear(const ImageF& cmyk) const = 0;
};
struct InkColor {
  std::string name;
  std::shared_ptr<const InkEncoding> encoding = {};
  std::string problem = {};
};
/// Color of a CMYK profile. Without one, or with one that cannot be used, `encoding` is null.
[[nodiscard]] InkColor color_of_cmyk_profile(const std::string& bytes);
inline constexpr std::array<double, 2> kD50White{0.34567, 0.35850};
/// CIE L*a*b* as linear Rec. 709. @param lab  3 channels. @param white  CIE xy. @returns 3 channels.
[[nodiscard]] ImageF linear_from_lab(const ImageF& lab, const std::array<double, 2>& white);

}  // namespace patinate
