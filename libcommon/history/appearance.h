/// \file
/// What a person says of a material that photographs from one side do not show: metal or not, how rough, what it
/// reflects.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "patinate/image/image.h"

namespace patinate {

/// Linear interpolation through points of rising x; constant beyond the ends.
struct ValueCurve {
  std::vector<std::array<double, 2>> points;  ///< x, value; at least one.
  [[nodiscard]] double at(double x) const;
};

/// A number of the material, wherever it is.
struct StatedValue {
  enum class By {
    Constant,  ///< The curve's first value.
    Time,      ///< Curve over the history's time.
    Control,   ///< Curve over the physical values of a control.
    Mask,      ///< Curve over the values of an image, [0, 1].
  };
  By by = By::Constant;
  ValueCurve curve;
  std::string control = "";         ///< Name for Control.
  std::filesystem::path mask = {};  ///< File for Mask.
};

/// Pixels that look like `color` in the photographs are this. Pixels between the colors of several materials are
/// mixtures.
struct StatedMaterial {
  std::array<double, 3> color{};  ///< Linear, [0, 1].
  double metalness = 0.0;         ///< [0, 1].
  /// Roughness of the mirror, [0, 1]; of all materials or of none.
  std::optional<double> roughness = {};
  /// Strength of the mirror of what is no metal (F0), [0, 1].
  std::optional<double> specular = {};
  /// Color of the mirror at normal incidence, linear, [0, 1]; of metal it stands for `color`, and lighter and darker
  /// pixels keep their relation to that. Nothing: metal reflects in its own color, the rest in white.
  std::optional<std::array<double, 3>> tint = {};
};

/// The `appearance` of a capture project.
struct Appearance {
  std::optional<StatedValue> metalness, roughness, specular;
  std::optional<std::array<double, 3>> tint;  ///< Linear, [0, 1].
  std::vector<StatedMaterial> materials;

  [[nodiscard]] bool is_empty() const;
  /// It differs from frame to frame.
  [[nodiscard]] bool has_course() const;
  /// Names of the maps that it makes, in the order of kFrameExtraNames.
  [[nodiscard]] std::vector<std::string> map_names() const;
};

/// Images that values are taken from, each of the history's size.
struct AppearanceSources {
  std::map<std::string, ImageF> controls;         ///< Physical values, by name.
  std::map<std::filesystem::path, ImageF> masks;  ///< [0, 1].
};

/// Maps as frames have them; empty where nothing is said.
struct AppearanceMaps {
  ImageF metalness, specular, tint;
  [[nodiscard]] const ImageF& of(const std::string& name) const;
};

/// The maps at a time.
///
/// With materials of colors c_i, a pixel of color p is made of shares w_i that are proportional to 1 / |p - c_i|^4,
/// with distances in sRGB codes [Shepard 1968]: exactly material i where p = c_i, whatever the others are. Numbers are
/// means by shares; tints are means by share times what the material reflects, m + (1 - m) F0.
/// @param color  The frame, H x W x 3, linear. @param sources  All that `appearance` names.
[[nodiscard]] AppearanceMaps appearance_maps(const Appearance& appearance, const AppearanceSources& sources,
                                             double time, const ImageF& color);

}  // namespace patinate
