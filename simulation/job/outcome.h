/// \file
/// What a run has done to its objects, in the figures that tell whether its rates are right.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patinate/simulation/engine.h"

namespace patinate::simulation {

/// Outcome of one material on one object. Means and shares are of the surface's area.
struct MaterialOutcome {
  std::string material;
  double mean = 0.0;         ///< Amount; 1 = a full layer.
  double largest = 0.0;      ///< Amount.
  double shows_share = 0.0;  ///< Where what has come covers a tenth of the color or more.
  double hides_share = 0.0;  ///< Where it covers all of it: more makes no difference.
  double full_share = 0.0;   ///< Where a texel holds no more (amount 4).
  double color_share = 0.0;  ///< Share of the color that new material covers: 95th percentile of the texels, or the
                             ///< mean where that is 0.
  bool is_made = false;      ///< By a rule.
};

struct ObjectOutcome {
  std::string object;
  double change_mean = 0.0;               ///< Delta E 1976 from the beginning.
  double change_p95 = 0.0;                ///< 95th percentile of the texels.
  std::optional<double> never_met_share;  ///< Where no gammaton ever was, as wide as it is. Unknown where
                                          ///< Simulation::met() is.
  std::vector<MaterialOutcome> materials;
};

/// @param before  Color at the beginning, H x W x 3, linear, of the atlas' size. @throws InvalidInput if it is not.
[[nodiscard]] std::vector<ObjectOutcome> outcome_of(Simulation& simulation, const ImageF& before,
                                                    const RunControl& control = {});

/// A change from here on is seen, as compare and fit have it.
inline constexpr double kVisibleDeltaE = 5.0;

/// Likely mistakes, one sentence each with its figure and what helps; none when all is well: nothing visible
/// happened, a material hides nearly everything, most of an object was never met.
[[nodiscard]] std::vector<std::string> outcome_advice(const std::vector<ObjectOutcome>& outcome);

}  // namespace patinate::simulation
