#include "patinate/simulation/weather.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "libcommon/core/portable_math.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::simulation {

namespace {

constexpr double kMaxTime = 1e15;  // in any unit; whole numbers of it are still exact
/// Ranges in the order of the signals: mm/h, degrees C, %, share, m/s.
constexpr WeatherValues kLeast{0.0, -273.15, 0.0, 0.0, 0.0};
constexpr WeatherValues kMost{1e4, 1e4, 100.0, 1.0, 1e3};

/// The row that holds at a time within the schedule.
std::size_t row_at(const Weather& weather, double time) {
  const auto next = std::upper_bound(weather.rows.begin(), weather.rows.end(), time,
                                     [](double t, const WeatherRow& row) { return t < row.time; });
  return next == weather.rows.begin() ? 0 : static_cast<std::size_t>(next - weather.rows.begin()) - 1;
}

/// Adds what a row is, times a weight.
void add(const WeatherRow& row, double weight, WeatherMean& sum) {
  for (std::size_t k = 0; k < kNumWeatherSignals; ++k) sum.values[k] += weight * row.values[k];
  const SineCosine from = portable_sine_cosine(row.wind_from_deg / 360.0);
  const double speed = row.values[static_cast<std::size_t>(WeatherSignal::Wind)];
  sum.wind_east_m_s -= weight * speed * from.sine;
  sum.wind_north_m_s -= weight * speed * from.cosine;
}

/// Adds the integral over [begin, end) of one pass of the schedule.
void add_pass(const Weather& weather, double begin, double end, WeatherMean& sum) {
  for (std::size_t i = row_at(weather, begin); begin < end && i < weather.rows.size(); ++i) {
    const double until = i + 1 < weather.rows.size() ? std::min(end, weather.rows[i + 1].time) : end;
    if (until > begin) add(weather.rows[i], until - begin, sum);
    begin = std::max(begin, until);
  }
}

/// Time since its pass began.
double time_in_pass(const Weather& weather, double time) {
  if (!(weather.repeat > 0.0)) return time;
  const double rest = time - std::floor(time / weather.repeat) * weather.repeat;
  return std::clamp(rest, 0.0, weather.repeat);
}

}  // namespace

WeatherMean mean_weather(const Weather& weather, double begin, double end) {
  WeatherMean sum;
  if (weather.empty()) return sum;
  const double length = end - begin;
  if (!(length > 0.0)) {
    add(weather.rows[row_at(weather, time_in_pass(weather, begin))], 1.0, sum);
    return sum;
  }
  if (!(weather.repeat > 0.0)) {
    add_pass(weather, begin, end, sum);
  } else {
    // Whole passes are all alike.
    const double from = time_in_pass(weather, begin);
    const double whole = std::floor((from + length) / weather.repeat);
    const double to = std::clamp(from + length - whole * weather.repeat, 0.0, weather.repeat);
    if (whole < 1.0) {
      add_pass(weather, from, from + length, sum);
    } else {
      add_pass(weather, from, weather.repeat, sum);
      if (to > 0.0) add_pass(weather, 0.0, to, sum);
      if (whole > 1.0) {
        WeatherMean pass;
        add_pass(weather, 0.0, weather.repeat, pass);
        for (std::size_t k = 0; k < kNumWeatherSignals; ++k) sum.values[k] += (whole - 1.0) * pass.values[k];
        sum.wind_east_m_s += (whole - 1.0) * pass.wind_east_m_s;
        sum.wind_north_m_s += (whole - 1.0) * pass.wind_north_m_s;
      }
    }
  }
  for (double& value : sum.values) value /= length;
  sum.wind_east_m_s /= length;
  sum.wind_north_m_s /= length;
  return sum;
}

double greatest_weather(const Weather& weather, WeatherSignal signal) {
  double greatest = 0.0;
  for (const WeatherRow& row : weather.rows)
    greatest = std::max(greatest, row.values[static_cast<std::size_t>(signal)]);
  return greatest;
}

std::optional<WeatherSignal> weather_signal_of(std::string_view name) {
  const auto* const found = std::find(kWeatherSignalNames.begin(), kWeatherSignalNames.end(), name);
  if (found == kWeatherSignalNames.end()) return std::nullopt;
  return static_cast<WeatherSignal>(found - kWeatherSignalNames.begin());
}

void check_row(const Weather& weather, std::size_t i) {
  const WeatherRow& row = weather.rows[i];
  if (!(row.time >= 0.0 && row.time <= kMaxTime))
    throw InvalidInput("the time of the weather is " + number_text(row.time) + "; use 0 or more");
  if (i > 0 && !(row.time > weather.rows[i - 1].time)) {
    throw InvalidInput("the time of the weather is " + number_text(row.time) + " after " +
                       number_text(weather.rows[i - 1].time) + "; rows go by time");
  }
  for (std::size_t k = 0; k < kNumWeatherSignals; ++k) {
    if (row.values[k] >= kLeast[k] && row.values[k] <= kMost[k]) continue;
    throw InvalidInput("the " + std::string(kWeatherSignalNames[k]) + " is " + number_text(row.values[k]) + "; use [" +
                       number_text(kLeast[k]) + ", " + number_text(kMost[k]) + "] " +
                       std::string(kWeatherSignalUnits[k]));
  }
  if (!(row.wind_from_deg >= -360.0 && row.wind_from_deg <= 360.0))
    throw InvalidInput("the direction of the wind is " + number_text(row.wind_from_deg) + "; use [-360, 360] degrees");
}

void check_weather(const Weather& weather) {
  for (std::size_t i = 0; i < weather.rows.size(); ++i) check_row(weather, i);
  if (weather.empty() || weather.repeat == 0.0) return;
  if (!(weather.repeat > weather.rows.back().time && weather.repeat <= kMaxTime)) {
    throw InvalidInput("the weather repeats after " + number_text(weather.repeat) +
                       "; use more than the time of its last row, " + number_text(weather.rows.back().time));
  }
}

}  // namespace patinate::simulation
