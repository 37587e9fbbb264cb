#include "analysis/factorization/forecast.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "libcommon/metrics/color_curves.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate::analysis {

namespace {

/// The first `count` times.
PlaceSeries beginning(const PlaceSeries& places, std::size_t count) {
  PlaceSeries out{.times = {places.times.begin(), places.times.begin() + static_cast<std::ptrdiff_t>(count)},
                  .num_channels = places.num_channels};
  const std::size_t num_times = places.times.size();
  const auto copy = [&](const auto& from, auto& to) {
    for (std::size_t at = 0; at < from.size(); at += num_times)
      to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(at),
                from.begin() + static_cast<std::ptrdiff_t>(at + count));
  };
  copy(places.values, out.values);
  copy(places.is_seen, out.is_seen);
  return out;
}

std::array<double, 3> lab_of(const std::array<double, 3>& rgb) { return lab_from_linear(rgb[0], rgb[1], rgb[2]); }

std::array<double, 3> seen_color(const PlaceSeries& places, std::int64_t i, std::size_t time) {
  const float* values = places.place(i);
  std::array<double, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<double>(values[c * places.times.size() + time]);
  return rgb;
}

/// Nothing where the curve does not tell.
std::optional<std::array<double, 3>> foretold(const Factorization& made, std::int64_t i, double time) {
  std::array<double, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t model = made.models.size() == 1 ? 0 : c;
    const PlaceFactors& place = made.factors[model][i];
    if (place.status == PlaceStatus::Unseen || place.status == PlaceStatus::Otherwise) return std::nullopt;
    rgb[c] = factored_value(made.models[model].curve, place, made.models.size() == 1 ? static_cast<int>(c) : 0, time);
  }
  return rgb;
}

}  // namespace

Forecast make_forecast(const PlaceSeries& places, const FactorizationOptions& options, const RunControl& control) {
  const std::size_t num_times = places.times.size(), num_held = std::max<std::size_t>(1, num_times / 5),
                    num_seen = num_times - num_held;
  Forecast forecast{.num_held = static_cast<int>(num_held)};
  if (num_seen < static_cast<std::size_t>(kLeastFrames)) {
    forecast.undefined = "without the last fifth there are too few frames";
    return forecast;
  }
  Factorization made;
  try {
    made = factorize(beginning(places, num_seen), options, control);
  } catch (const InvalidInput&) {
    forecast.undefined = "nothing had changed before the last fifth of the frames";
    return forecast;
  }
  double count = 0.0;
  for (std::int64_t i = 0; i < places.num_places(); ++i) {
    const std::uint8_t* seen = places.seen(i);
    const auto held = foretold(made, i, places.times[num_seen - 1]);
    if (!held) continue;
    for (std::size_t t = num_seen; t < num_times; ++t) {
      if (seen != nullptr && seen[t] == 0) continue;
      const auto truth = lab_of(seen_color(places, i, t));
      forecast.curve += ciede2000(lab_of(*foretold(made, i, places.times[t])), truth);
      forecast.last += ciede2000(lab_of(*held), truth);
      count += 1.0;
    }
  }
  if (count == 0.0) {
    forecast.undefined = "the last fifth of the frames shows no place that the others do";
    return forecast;
  }
  forecast.curve /= count;
  forecast.last /= count;
  return forecast;
}

Json forecast_json(const Forecast& forecast) {
  return {{"held_out", forecast.num_held},
          {"curve", forecast.curve},
          {"last", forecast.last},
          {"undefined", forecast.undefined}};
}

Forecast forecast_from_json(const Json& json) {
  return {.num_held = json.at("held_out"),
          .curve = json.at("curve"),
          .last = json.at("last"),
          .undefined = json.at("undefined")};
}

}  // namespace patinate::analysis
