/// \file
/// Weather over a scene's time: rain, temperature, humidity, sunshine and wind as a schedule.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace patinate::simulation {

enum class WeatherSignal { Rain, Temperature, Humidity, Sunshine, Wind };
inline constexpr std::size_t kNumWeatherSignals = 5;
/// Names of the signals in drivers of rules, and the units of their values.
inline constexpr std::array<std::string_view, kNumWeatherSignals> kWeatherSignalNames{"rain", "temperature", "humidity",
                                                                                      "sunshine", "wind"};
inline constexpr std::array<std::string_view, kNumWeatherSignals> kWeatherSignalUnits{"mm/h", "degC", "%", "1", "m/s"};

using WeatherValues = std::array<double, kNumWeatherSignals>;

/// From its time until the next one's.
struct WeatherRow {
  double time = 0.0;           ///< In the scene's unit of time, >= 0.
  WeatherValues values{};      ///< By WeatherSignal: mm/h >= 0, degC, % in [0, 100], [0, 1], m/s >= 0.
  double wind_from_deg = 0.0;  ///< Where the wind comes from: 0 = north, 90 = east.
};

/// Piecewise constant: a row holds until the next one's time, the first one also before its own, the last one for ever
/// or until the whole repeats.
struct Weather {
  std::vector<WeatherRow> rows;                     ///< By time, which differ; empty = no weather.
  std::array<bool, kNumWeatherSignals> is_given{};  ///< Signals that the weather defines.
  double repeat = 0.0;  ///< It begins again after so much time, more than the last row's; 0 = never.

  [[nodiscard]] bool empty() const { return rows.empty(); }
};

/// Means over [begin, end); those at `begin` where the end is not later. 0 for what is not given.
/// @param weather  Checked (check_weather()). Sums and products only: the same bits everywhere.
struct WeatherMean {
  WeatherValues values{};
  double wind_east_m_s = 0.0;  ///< Mean of the vector of motion.
  double wind_north_m_s = 0.0;
};
[[nodiscard]] WeatherMean mean_weather(const Weather& weather, double begin, double end);

/// The greatest value of a signal in any row.
[[nodiscard]] double greatest_weather(const Weather& weather, WeatherSignal signal);

/// The signal of that name.
[[nodiscard]] std::optional<WeatherSignal> weather_signal_of(std::string_view name);

/// @throws InvalidInput if the row's time is not later than the one's before, or a value cannot be.
void check_row(const Weather& weather, std::size_t row);
/// All rows, and when they repeat. @throws InvalidInput
void check_weather(const Weather& weather);

}  // namespace patinate::simulation
