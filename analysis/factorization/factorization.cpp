#include "patinate/analysis/factorization.h"

#include <algorithm>
#include <cmath>

#include "analysis/factorization/place_fit.h"
#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::array<std::string_view, 2> kFactorClockNames{"shared", "channels"};
constexpr std::int64_t kChunk = 32;

void check(const PlaceSeries& places) {
  if (places.num_channels < 1 || places.num_channels > 3)
    throw InvalidInput("factorize: there must be 1 to 3 channels");
  if (static_cast<int>(places.times.size()) < kLeastFrames) {
    throw InvalidInput("factorize: there " +
                       std::string(places.times.size() == 1
                                       ? "is 1 frame"
                                       : "are " + std::to_string(places.times.size()) + " frames") +
                       "; a curve with rates and offsets needs at least " + std::to_string(kLeastFrames));
  }
  for (std::size_t t = 1; t < places.times.size(); ++t) {
    if (!(places.times[t] > places.times[t - 1]))
      throw InvalidInput("factorize: times must be strictly increasing; found " + number_text(places.times[t]) +
                         " after " + number_text(places.times[t - 1]));
  }
  if (places.values.size() % (places.times.size() * static_cast<std::size_t>(places.num_channels)) != 0)
    throw InvalidInput("factorize: values are no whole number of places");
  if (!places.is_seen.empty() &&
      places.is_seen.size() * static_cast<std::size_t>(places.num_channels) != places.values.size())
    throw InvalidInput("factorize: is_seen must hold a flag for every place and time");
}

}  // namespace

void describe(OptionVisitor& v, FactorizationOptions& o) {
  v.visit_choice({"clock", "One rate and offset of a place for all channels, or one for each channel"}, o.clock,
                 kFactorClockNames);
  v.visit({"num_intervals", "Pieces of the curve's spline; more follow faster changes", "", between(2, 400)},
          o.num_intervals);
  v.visit(
      {"max_rate", "Largest factor by which a place ages faster or slower than the median place", "", between(1.1, 20)},
      o.max_rate);
  v.visit({"least_change", "Smallest change of linear color; places that change less count as unchanged", "", above(0)},
          o.least_change);
  v.visit({"num_training", "Places that the curve is fitted to", "", between(16, 4096)}, o.num_training);
}

PlaceSeries PlaceSeries::channel(int c) const {
  PlaceSeries out{.times = times, .num_channels = 1, .is_seen = is_seen};
  for (std::int64_t i = 0; i < num_places(); ++i) {
    const float* begin = place(i) + static_cast<std::size_t>(c) * times.size();
    out.values.insert(out.values.end(), begin, begin + times.size());
  }
  return out;
}

std::vector<PlaceFactors> fit_places(const PlaceSeries& places, const TemporalModel& model,
                                     const FactorizationOptions& options, const RunControl& control) {
  check(places);
  const PlaceFit fit(model, places.times, options);
  std::vector<PlaceFactors> factors(static_cast<std::size_t>(places.num_places()));
  parallel_for(places.num_places(), kChunk, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) factors[i] = fit.solve(places.place(i), places.seen(i));
  });
  return factors;
}

ClockGauge clock_gauge(const std::vector<PlaceFactors>& factors) {
  std::vector<double> rates, offsets;
  for (const PlaceFactors& f : factors) {
    if (f.status == PlaceStatus::Fitted) rates.push_back(f.rate), offsets.push_back(f.offset);
  }
  if (rates.empty()) return {};
  const double scale = 1.0 / median(rates);
  return {.scale = scale, .shift = scale * median(offsets)};
}

void apply_gauge(const ClockGauge& gauge, TemporalCurve& curve) {
  curve.low = gauge.scale * curve.low + gauge.shift;
  curve.high = gauge.scale * curve.high + gauge.shift;
}

void apply_gauge(const ClockGauge& gauge, std::vector<PlaceFactors>& factors) {
  for (PlaceFactors& f : factors) {
    if (f.status != PlaceStatus::Fitted && f.status != PlaceStatus::Open) continue;
    f.rate *= gauge.scale, f.rate_stddev *= gauge.scale;
    f.offset = gauge.scale * f.offset - gauge.shift;
  }
}

Factorization factorize(const PlaceSeries& places, const FactorizationOptions& options, const RunControl& control) {
  Factorization out;
  const int num_models = options.clock == FactorClock::Shared ? 1 : places.num_channels;
  for (int m = 0; m < num_models; ++m) {
    const RunControl part = control.part(static_cast<double>(m) / num_models, (m + 1.0) / num_models);
    const PlaceSeries one = num_models == 1 ? PlaceSeries() : places.channel(m);
    const PlaceSeries& used = num_models == 1 ? places : one;
    out.models.push_back(train_curve(used, options, part.part(0.0, 0.5)));
    out.factors.push_back(fit_places(used, out.models.back(), options, part.part(0.5, 1.0)));
    const ClockGauge gauge = clock_gauge(out.factors.back());
    apply_gauge(gauge, out.models.back().curve);
    apply_gauge(gauge, out.factors.back());
  }
  return out;
}

Factorization factorize(const History& history, const FactorizationOptions& options, const RunControl& control) {
  const ImageU8 mask = history.read_mask();
  std::vector<std::uint32_t> pixels;
  for (std::int64_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] != 0) pixels.push_back(static_cast<std::uint32_t>(i));
  }
  return factorize(place_series(history, pixels, control.part(0.0, 0.1)), options, control.part(0.1, 1.0));
}

PlaceSeries place_series(const History& history, std::span<const std::uint32_t> pixels, const RunControl& control) {
  PlaceSeries out{.times = history.times()};
  const std::size_t num_times = out.times.size(), n = pixels.size();
  out.values.resize(n * 3 * num_times);
  for (std::size_t t = 0; t < num_times; ++t) {
    control.throw_if_stopped();
    const ImageF frame = history.read_frame(static_cast<int>(t));
    const ImageU8 seen = history.facts().frames[t].has_mask ? history.read_frame_mask(static_cast<int>(t)) : ImageU8();
    if (!seen.empty() && out.is_seen.empty()) out.is_seen.assign(n * num_times, 255);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        out.values[(3 * i + c) * num_times + t] = frame.data()[std::size_t{3} * pixels[i] + c];
      if (!seen.empty()) out.is_seen[i * num_times + t] = seen.data()[pixels[i]];
    }
    control.report((static_cast<double>(t) + 1.0) / static_cast<double>(num_times));
  }
  return out;
}

double factored_value(const TemporalCurve& curve, const PlaceFactors& place, int channel, double time) {
  const auto c = static_cast<std::size_t>(channel);
  return place.gain[c] == 0.0 ? place.base[c]
                              : place.gain[c] * curve.value(channel, place.rate * time - place.offset) + place.base[c];
}

bool is_covered(const TemporalCurve& curve, const PlaceFactors& place, double time) {
  if (place.status != PlaceStatus::Fitted && place.status != PlaceStatus::Open)
    return place.status == PlaceStatus::Unchanged;
  const double clock = place.rate * time - place.offset;
  return clock >= curve.low && clock <= curve.high;
}

}  // namespace patinate::analysis
