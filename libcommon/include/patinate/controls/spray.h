/// \file
/// Thickness of paint from a nozzle that follows a path.
#pragma once

#include <optional>
#include <vector>

#include "patinate/controls/control_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Settings of spray_map().
struct SprayOptions {
  double spread_deg = 12.0;    ///< Standard deviation of the cone's Gaussian profile; (0, 90].
  bool casts_shadows = true;   ///< Whether the surface keeps paint from what lies behind it.
  double full_percent = 99.0;  ///< This share of the area is at most what 1 stands for; [51, 100].
};
void describe(OptionVisitor& visitor, SprayOptions& options);

/// One stop of the nozzle.
struct SprayStop {
  Vec3 position_mm = Vec3::Zero();
  double dwell = 1.0;                  ///< Time spent there, any unit; >= 0.
  Vec3 aim_mm = Vec3::Zero();          ///< Point that the nozzle looks at.
  std::optional<double> spread_deg{};  ///< Of this stop; (0, 90]. Not given: SprayOptions::spread_deg.
};

/// A painted stroke: the nozzle moves straight from point to point while it sprays.
struct SprayStroke {
  std::vector<SprayStop>
      points;         ///< `dwell` is the time from a point to the next; of a single point, the time spent there.
  double flow = 1.0;  ///< Paint for each unit of time; >= 0.
};

/// The stops that paint as the strokes do: so many along each way that they lie less than 0.1 of the distance to the
/// aim apart (at most 500 a way), each with its part of the paint; position, aim and spread are interpolated.
/// @throws InvalidInput if a stroke has no point or a flow is not finite and >= 0.
[[nodiscard]] std::vector<SprayStop> stroke_stops(const std::vector<SprayStroke>& strokes,
                                                  const SprayOptions& options = {});

/// One stop, up and in front (+y, +z) of the bounding box at 1.5 times its diagonal, that looks at its center.
[[nodiscard]] std::vector<SprayStop> default_spray_path(const Mesh& mesh);

/// Paint on every texel: the sum over stops of dwell * exp(-angle^2 / (2 spread^2)) * max(0, n . l) / d^2, where
/// `angle` is between the aim and the texel, l the direction to the nozzle, n the shading normal, d the distance; 0
/// where the surface is in the way. Stops add up. Stops that paint nothing are noted, and a
/// nozzle that never comes nearer than 20 diagonals. Range: from 0 to the `full_percent` percentile by area (to the
/// greatest value if that is 0), unit "relative".
/// @throws InvalidInput if the path is empty or not finite, dwells are negative, an aim equals its position, or no
/// paint arrives: every stop is behind the surface, or its cone passes the object by more than 4.5 spreads. Cost: one
/// ray for each texel and stop. Same bits for any number of threads.
[[nodiscard]] ControlMap spray_map(const TexelMap& map, const std::vector<SprayStop>& path,
                                   const SprayOptions& options = {}, const RunControl& control = {});

}  // namespace patinate
