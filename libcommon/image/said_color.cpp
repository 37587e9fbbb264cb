#include <array>
#include <cmath>

#include "libcommon/core/text.h"
#include "libcommon/image/file_words.h"

namespace patinate {

std::string pixel_shape_problem(double width) {
  constexpr double kNearlySquare = 0.01;
  if (!(width > 0.0) || !std::isfinite(width) || std::abs(std::log(width)) <= kNearlySquare) return "";
  return "its pixels, " +
         (width > 1.0 ? short_number_text(rounded(width, 4)) + " times as wide as high"
                      : short_number_text(rounded(1.0 / width, 4)) + " times as high as wide") +
         ", are taken as square";
}

SaidColor said_color(const FileWords& words, int channels, bool is_light) {
  std::string problem;
  if (words.code_points) {
    SaidColor color = color_of_code_points(words.code_points->primaries, words.code_points->transfer,
                                           words.code_points->is_full_range);
    color.name += " (color code points)";
    if (color.problem.empty()) return color;
    problem = color.problem;
  }
  if (!words.icc.empty()) {
    SaidColor color = color_of_profile(words.icc, channels);
    if (color.problem.empty()) return color;
    problem = color.problem;
  }
  SaidColor color;
  // Gamma that the PNG specification gives beside sRGB; what writes it means sRGB.
  constexpr double kSrgbGamma = 0.45455, kNear = 2e-5;
  const bool is_srgb_gamma = words.png_gamma && std::abs(*words.png_gamma - kSrgbGamma) < kNear;
  const bool is_linear = words.png_gamma && *words.png_gamma == 1.0;
  if (words.is_srgb) {
    color.name = "sRGB";
  } else if (words.is_adobe_rgb) {
    color = color_of_primaries("Adobe RGB (EXIF)", kAdobeRgb, 563.0 / 256.0);
  } else if (words.png_gamma || words.primaries) {
    const Chromaticities primaries = words.primaries.value_or(kRec709);
    std::string said = words.png_gamma ? "PNG gAMA" : words.primaries_by;
    if (words.png_gamma && words.primaries) said += " and cHRM";
    const std::string name = primaries_name(primaries) + " (" + said + ")";
    if (!words.png_gamma)
      color = is_light ? light_of_primaries(name, primaries) : srgb_color_of_primaries(name, primaries);
    if (words.png_gamma) {
      color = color_of_primaries(
          (is_linear ? "linear" : "gamma " + short_number_text(std::round(1e3 / *words.png_gamma) / 1e3)) +
              (words.primaries ? ", " + primaries_name(primaries) : std::string()) + " (" + said + ")",
          primaries, 1.0 / *words.png_gamma);
    }
    if (is_srgb_gamma) {
      SaidColor srgb = srgb_color_of_primaries("sRGB (" + said + ")", primaries);
      if (srgb.problem.empty() && srgb.encoding == nullptr) color = srgb;
    }
  }
  if (!color.problem.empty()) problem = color.problem;
  color.problem = problem;
  return color;
}

std::string orientation_words(int orientation) {
  constexpr std::array kTexts{"",
                              "",
                              "mirrored left to right",
                              "turned by 180 degrees",
                              "mirrored top to bottom",
                              "mirrored along the diagonal from top left",
                              "turned by 90 degrees clockwise",
                              "mirrored along the diagonal from top right",
                              "turned by 90 degrees counterclockwise"};
  return kTexts[orientation];
}

std::string orientation_text(int orientation) {
  return orientation <= 1 ? ""
                          : orientation_words(orientation) + " (EXIF orientation " + std::to_string(orientation) + ")";
}

}  // namespace patinate
