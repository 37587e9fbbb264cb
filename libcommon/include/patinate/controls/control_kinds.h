/// \file
/// Every kind of control map by name, for command lines and files. A new kind is one line of the table in the .cpp, and
/// a member of ControlKindOptions if it has options.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/controls/accessibility.h"
#include "patinate/controls/distance.h"
#include "patinate/controls/exposure.h"
#include "patinate/controls/spray.h"

namespace patinate {

/// The options of all kinds. Paths stand here because a kind chosen by name reads its own input.
struct ControlKindOptions {
  std::array<double, 3> up{0.0, 1.0,
                           0.0};  ///< Which way is up for sky, sun and height; any length > 0. Default: as in glTF.
  AccessibilityOptions accessibility;
  RayShareOptions ray_share;
  TangentSphereOptions tangent_sphere;
  ExposureOptions exposure;
  SunOptions sun;
  FacingOptions facing;
  DistanceOptions distance;
  SprayOptions spray;
  std::string sky;            ///< Panorama of the kind `exposure`; "" = an even sky.
  std::string distance_from;  ///< "boundary", "creases", "ridges", "valleys", a CSV of curves or an image; needed by
                              ///< `distance`.
  std::string spray_path;     ///< File of read_spray_path(); "" = default_spray_path().
  std::string image;          ///< Image of the kind `image`.
};
void describe(OptionVisitor& visitor, ControlKindOptions& options);

/// A kind of control that a user can choose.
struct ControlKind {
  std::string name;   ///< As it stands in expressions.
  std::string brief;  ///< Where it is high, in a few words.
};
/// In the order in which help and documents list them.
[[nodiscard]] const std::vector<ControlKind>& control_kinds();
/// Their names.
[[nodiscard]] const std::vector<std::string>& control_kind_names();

/// Raised when the same input gives other values: part of every key that stands for a map.
inline constexpr int kControlVersion = 3;

/// The options that a kind uses; all others have their defaults. @param kind  One of control_kind_names().
[[nodiscard]] ControlKindOptions used_options(const std::string& kind, const ControlKindOptions& options);

/// Names of the options that a kind looks at, in their order. @param kind  One of control_kind_names().
[[nodiscard]] std::vector<std::string> control_option_names(const std::string& kind);

/// Files that make_control() would read: part of what its result depends on. @throws ParseError if an option that
/// should name a file names nothing.
[[nodiscard]] std::vector<std::filesystem::path> control_input_files(const std::string& kind,
                                                                     const ControlKindOptions& options);

/// @throws ParseError for a kind that does not exist (with a did-you-mean) or whose input is not given; what the kind
/// throws.
[[nodiscard]] ControlMap make_control(const std::string& kind, const TexelMap& map,
                                      const ControlKindOptions& options = {}, const RunControl& control = {});

/// A ready-made map: image_map() of a file's channel `Y`, its only one, or the mean of its colors. Over an atlas of
/// tiles: the files of tile_map_files(), laid over their tiles.
/// @throws IoError
[[nodiscard]] ControlMap read_control_file(const std::filesystem::path& path, const TexelMap& map);

/// A function that makes the map of a kind: make_control(), or one with a cache.
using ControlSource =
    std::function<ControlMap(const std::string& kind, const TexelMap&, const ControlKindOptions&, const RunControl&)>;

/// An expression of kinds and files (ControlExpression); a kind's arguments, as in `accessibility(scale=3)`, come
/// before `options`. Maps that are even are noted.
/// @param source  Of the kinds; empty: make_control(). @throws ParseError, and what its parts throw.
[[nodiscard]] ControlMap make_control_expression(std::string_view expression, const TexelMap& map,
                                                 const ControlKindOptions& options = {}, const RunControl& control = {},
                                                 const ControlSource& source = {});

}  // namespace patinate
