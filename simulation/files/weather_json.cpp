#include "simulation/files/weather_json.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::simulation {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxRows = 1'000'000;
constexpr std::uint64_t kMaxBytes = std::uint64_t{128} << 20;

/// Values of a row beside its time: the weather's signals, then where the wind comes from.
constexpr std::size_t kDirection = kNumWeatherSignals;
constexpr std::size_t kNumFields = kNumWeatherSignals + 1;
constexpr std::array<std::string_view, kNumFields> kFieldNames{"rain",     "temperature", "humidity",
                                                               "sunshine", "wind",        "wind_direction"};
/// Spellings of units, the first for messages.
constexpr std::array<std::array<std::string_view, 3>, kNumFields> kFieldUnits{{{"mm/h", "", ""},
                                                                               {"degC", "C", "°C"},
                                                                               {"%", "", ""},
                                                                               {"0..1", "1", ""},
                                                                               {"m/s", "", ""},
                                                                               {"deg", "°", "degrees"}}};

double& field_of(WeatherRow& row, std::size_t field) {
  return field == kDirection ? row.wind_from_deg : row.values[field];
}

/// The field of a column or member; kNumFields for none. "sun" is what files call sunshine.
std::size_t field_index(std::string_view name) {
  if (name == "sun") name = "sunshine";
  return static_cast<std::size_t>(std::find(kFieldNames.begin(), kFieldNames.end(), name) - kFieldNames.begin());
}

std::vector<std::string> column_names() {
  std::vector<std::string> names{"time"};
  names.insert(names.end(), kFieldNames.begin(), kFieldNames.end());
  names.emplace_back("sun");
  return names;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  return text;
}

/// Table of a CSV: its columns and where they stand.
class WeatherTable {
 public:
  WeatherTable(fs::path path, TimeUnit unit) : path_(std::move(path)), unit_(unit) {}

  [[nodiscard]] Weather read() {
    const std::string text = read_file(path_, kMaxBytes);
    std::string_view rest = text;
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      const std::string_view line = trimmed(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
      ++line_;
      if (line.empty() || line.front() == '#') continue;
      if (columns_.empty()) {
        read_header(line);
      } else {
        read_row(line);
      }
    }
    if (weather_.rows.empty())
      throw IoError(path_.string(), "holds no weather; expected a line of column names and lines of numbers");
    return std::move(weather_);
  }

 private:
  static constexpr std::size_t kTime = kNumFields;

  [[noreturn]] void fail(const std::string& problem) const {
    throw IoError(path_.string(), "line " + std::to_string(line_) + ": " + problem);
  }

  /// "rain (mm/h)" or "rain [mm/h]" in two.
  static std::pair<std::string, std::string> name_and_unit(const std::string& cell) {
    const std::size_t open = cell.find_first_of("([");
    if (open == std::string::npos) return {std::string(trimmed(cell)), ""};
    const std::size_t close = cell.find_last_of(")]");
    const std::size_t length = close == std::string::npos || close < open ? std::string::npos : close - open - 1;
    return {std::string(trimmed(std::string_view(cell).substr(0, open))),
            std::string(trimmed(std::string_view(cell).substr(open + 1, length)))};
  }

  void read_header(std::string_view line) {
    for (const std::string& cell : split(line, ',')) {
      const auto [name, unit] = name_and_unit(cell);
      std::size_t column = field_index(name);
      if (name == "time") {
        column = kTime;
        const std::optional<double> seconds = seconds_of_unit(unit);
        if (!seconds) fail("the unit of `" + cell + "`: use time (s), (min), (h), (d), (month) or (a)");
        units_per_cell_ = *seconds / seconds_per(unit_);
      } else if (column == kNumFields) {
        const std::vector<std::string> known = column_names();
        std::string list;
        for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
        fail("there is no column `" + name + "`; use " + list + did_you_mean(name, known));
      } else if (const auto& units = kFieldUnits[column];
                 !unit.empty() && std::find(units.begin(), units.end(), unit) == units.end()) {
        fail("the unit of `" + cell + "`: use " + name + " (" + std::string(units.front()) + ")");
      }
      if (std::find(columns_.begin(), columns_.end(), column) != columns_.end())
        fail("the column `" + name + "` is there twice");
      columns_.push_back(column);
      if (column < kNumWeatherSignals) weather_.is_given[column] = true;
    }
    if (std::find(columns_.begin(), columns_.end(), kTime) == columns_.end())
      fail("a column `time` with a unit is missing, as time (h)");
    if (columns_.size() < 2) fail("a column beside the time is missing");
  }

  void read_row(std::string_view line) {
    const std::vector<std::string> cells = split(line, ',');
    if (cells.size() != columns_.size()) {
      fail("found " + std::to_string(cells.size()) + " values; expected " + std::to_string(columns_.size()) +
           ", one for each column");
    }
    if (weather_.rows.size() >= kMaxRows) fail("more than " + std::to_string(kMaxRows) + " rows");
    WeatherRow row = weather_.rows.empty() ? WeatherRow{} : weather_.rows.back();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::string name = columns_[i] == kTime ? "time" : std::string(kFieldNames[columns_[i]]);
      if (cells[i].empty() && columns_[i] != kTime && !weather_.rows.empty()) continue;
      const std::optional<double> number = parse_number(cells[i]);
      if (!number) fail("`" + name + "`: found `" + cells[i] + "`; expected a number");
      if (columns_[i] == kTime) {
        row.time = *number * units_per_cell_;
      } else {
        field_of(row, columns_[i]) = *number;
      }
    }
    weather_.rows.push_back(row);
    try {
      check_row(weather_, weather_.rows.size() - 1);
    } catch (const InvalidInput& e) {
      fail(e.what());
    }
  }

  fs::path path_;
  TimeUnit unit_;
  int line_ = 0;
  double units_per_cell_ = 1.0;
  std::vector<std::size_t> columns_;  ///< Their fields, or kTime.
  Weather weather_;
};

Weather read_rows(const JsonReader& json, TimeUnit unit) {
  Weather weather;
  for (JsonReader& element : json.elements(kMaxRows)) {
    WeatherRow row = weather.rows.empty() ? WeatherRow{} : weather.rows.back();
    row.time = read_time_value(element.member("time"), unit);
    for (const std::string& key : element.keys()) {
      const std::size_t field = field_index(key);
      if (field == kNumFields || (key == "sunshine" && element.has("sun"))) continue;
      field_of(row, field) = element.member(key).number();
      if (field < kNumWeatherSignals) weather.is_given[field] = true;
    }
    for (const std::string_view name : kFieldNames) (void)element.has(name);
    element.finish();
    weather.rows.push_back(row);
    try {
      check_row(weather, weather.rows.size() - 1);
    } catch (const InvalidInput& e) {
      throw IoError(element.file(), element.pointer() + ": " + e.what());
    }
  }
  if (weather.rows.empty()) json.fail("at least one row of weather");
  return weather;
}

Weather read_csv(const JsonReader& path, const SceneContext& context, TimeUnit unit) {
  context.add_input("weather", path.path());
  return read_weather_csv(path.path(), unit);
}

}  // namespace

std::optional<double> seconds_of_unit(std::string_view unit) {
  constexpr double kDay = 86400.0, kYear = 365.25 * kDay;  // s; a year is 365.25 days (docs/simulation.md).
  constexpr std::array<std::pair<std::string_view, double>, 8> kUnits{{{"s", 1.0},
                                                                       {"min", 60.0},
                                                                       {"h", 3600.0},
                                                                       {"d", kDay},
                                                                       {"month", kYear / 12.0},
                                                                       {"a", kYear},
                                                                       {"year", kYear},
                                                                       {"years", kYear}}};
  const auto* const found = std::find_if(kUnits.begin(), kUnits.end(), [&](const auto& u) { return u.first == unit; });
  return found == kUnits.end() ? std::nullopt : std::optional(found->second);
}

double read_time_value(const JsonReader& json, TimeUnit unit) {
  if (json.is_number()) return json.number(at_least(0));
  const std::string text = json.is_string() ? json.string() : "";
  const std::size_t end = text.find_last_of("0123456789.") + 1;  // 0 where there is none
  const std::optional<double> number = parse_number(trimmed(std::string_view(text).substr(0, end)));
  const std::optional<double> seconds = seconds_of_unit(trimmed(std::string_view(text).substr(end)));
  if (!number || !seconds || !(*number >= 0.0))
    json.fail("a time: a number in the scene's unit of time, or text with a unit as \"6 h\" (s, min, h, d, month, a)");
  return *number * (*seconds / seconds_per(unit));
}

Weather read_weather_csv(const fs::path& path, TimeUnit unit) { return WeatherTable(path, unit).read(); }

Weather read_weather(const JsonReader& json, const SceneContext& context, TimeUnit unit) {
  if (json.is_string()) return read_csv(json, context, unit);
  if (json.is_array()) return read_rows(json, unit);
  if (!json.is_object()) json.fail("the path of a CSV, a list of rows, or an object with \"file\" or \"rows\"");
  JsonReader members = json;
  if (members.has("file") == members.has("rows")) json.fail("\"file\" or \"rows\"");
  Weather weather =
      members.has("file") ? read_csv(members.member("file"), context, unit) : read_rows(members.member("rows"), unit);
  if (members.has("repeat")) weather.repeat = read_time_value(members.member("repeat"), unit);
  members.finish();
  try {
    check_weather(weather);
  } catch (const InvalidInput& e) {
    throw IoError(json.file(), json.pointer() + ": " + e.what());
  }
  return weather;
}

}  // namespace patinate::simulation
