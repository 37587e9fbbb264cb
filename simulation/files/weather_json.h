/// \file
/// "weather" of a scene file, rows or a CSV, and times with a unit. For scene_io.cpp and scene_json.cpp.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "patinate/core/json.h"
#include "patinate/history/history_value.h"
#include "patinate/simulation/weather.h"
#include "simulation/files/scene_json.h"

namespace patinate::simulation {

/// Seconds of a unit of time: s, min, h, d, month (a twelfth of a year), a or year (365.25 d). Nothing for another.
[[nodiscard]] std::optional<double> seconds_of_unit(std::string_view unit);

/// A time >= 0 in `unit`: a number, or text with a unit of its own, "3.5 a". @throws IoError
[[nodiscard]] double read_time_value(const JsonReader& json, TimeUnit unit);

/// The path of a CSV, a list of rows, or {"file": PATH or "rows": LIST, "repeat": TIME}. In a list, what a row does not
/// say is as in the row before.
/// @throws IoError naming the row, the line or the column.
[[nodiscard]] Weather read_weather(const JsonReader& json, const SceneContext& context, TimeUnit unit);

/// Lines of numbers below a line of column names with units: "time (h), rain (mm/h), temperature (degC), humidity (%),
/// sun (0..1), wind (m/s), wind_direction (deg)", the time and any of the others. An empty cell is as the one above.
/// @throws IoError naming line and column.
[[nodiscard]] Weather read_weather_csv(const std::filesystem::path& path, TimeUnit unit);

}  // namespace patinate::simulation
