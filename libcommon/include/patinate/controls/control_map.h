/// \file
/// What a control map is, and how values become one.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "patinate/atlas/texel_map.h"
#include "patinate/image/image.h"

namespace patinate {

/// A parameter of the surface that aging follows, over an atlas.
struct ControlMap {
  ImageF values;                     ///< H x W x 1 in [0, 1]; 0 outside the charts.
  double low = 0.0;                  ///< Physical value of 0, in `unit`.
  double high = 1.0;                 ///< Physical value of 1, in `unit`; > low unless the map was inverted.
  std::string unit;                  ///< "1/mm", "cosine", ...; "relative" when only ratios mean something.
  bool has_file = false;             ///< A map file takes part: painted, not computed from the shape alone.
  std::vector<std::string> notes{};  ///< What a user should know about it: whole sentences without a full stop.
};

/// Least and greatest value of what is normalized; values beyond are clamped.
struct ValueRange {
  double low = 0.0;
  double high = 1.0;
};

/// Values below which `low_percent` and `high_percent` of the surface's area lie, each texel weighted by its area in
/// mm^2.
/// @param values  Size of `map`; outside the charts not looked at.
/// @throws InvalidInput if no texel is covered.
[[nodiscard]] ValueRange area_percentiles(const ImageF& values, const TexelMap& map, double low_percent,
                                          double high_percent);

/// (value - low) / (high - low), clamped to [0, 1]; 0 outside the charts. @throws InvalidInput unless high > low.
[[nodiscard]] ControlMap normalized_control(const ImageF& values, const TexelMap& map, const ValueRange& range,
                                            std::string unit);

/// Unit vector along three numbers of an option. @throws InvalidInput naming the option unless their length is finite
/// and > 0.
[[nodiscard]] Vec3 unit_direction(const std::array<double, 3>& numbers, const std::string& option);

/// Adds a note if the map is the same on the whole surface (to 0.001), so that it guides nothing.
/// @param name  What the note calls it.
void note_if_even(ControlMap& control, const ImageU8& coverage, const std::string& name);

}  // namespace patinate
