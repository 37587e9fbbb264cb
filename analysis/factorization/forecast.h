/// \file
/// Whether a curve foretells what nobody saw.
#pragma once

#include <optional>

#include "patinate/analysis/factorization.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

/// A factorization of all but the last fifth of the times, against that fifth and against what was seen last.
struct Forecast {
  int num_held = 0;    ///< Times that it did not see.
  double curve = 0.0;  ///< CIEDE2000 of its colors there, in the mean.
  double last = 0.0;   ///< The same of the last color that it saw, held.
  [[nodiscard]] bool has_skill() const { return curve < last; }
};
/// Of places that the curve covers there or that change in no other way; nothing where fewer than kLeastFrames times or
/// none of the places would be left.
/// @param places  Of 3 channels. Cost: as factorize().
[[nodiscard]] std::optional<Forecast> make_forecast(const PlaceSeries& places, const FactorizationOptions& options,
                                                    const RunControl& control = {});

[[nodiscard]] Json forecast_json(const std::optional<Forecast>& forecast);
/// The inverse; for files of our own only.
[[nodiscard]] std::optional<Forecast> forecast_from_json(const Json& json);

}  // namespace patinate::analysis
