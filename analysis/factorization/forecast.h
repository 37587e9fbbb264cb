/// \file
/// Whether a curve foretells what nobody saw.
#pragma once

#include <string>

#include "patinate/analysis/factorization.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

/// A factorization of all but the last fifth of the times, asked for that fifth: as its curve goes on, and as it was at
/// the last time that it saw.
struct Forecast {
  int num_held = 0;            ///< Times that it did not see.
  double curve = 0.0;          ///< CIEDE2000 of its colors there, in the mean.
  double last = 0.0;           ///< Error of its colors at the last time that it saw, held.
  std::string undefined = "";  ///< Why nothing can be said; then there is no skill.
  [[nodiscard]] bool has_skill() const { return undefined.empty() && curve < last; }
};
/// Tests the forecast on places that are seen and do not change otherwise.
/// @param places  Of 3 channels. Cost: as factorize().
[[nodiscard]] Forecast make_forecast(const PlaceSeries& places, const FactorizationOptions& options,
                                     const RunControl& control = {});

[[nodiscard]] Json forecast_json(const Forecast& forecast);
/// The inverse; for files of our own only.
[[nodiscard]] Forecast forecast_from_json(const Json& json);

}  // namespace patinate::analysis
