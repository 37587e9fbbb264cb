// "weather" of a scene file, and times with a unit in it.
#include "simulation/files/weather_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "tests/support/errors.h"
#include "tests/support/plate_scene.h"
#include "tests/support/temp_folder.h"

namespace patinate::simulation {
namespace {

using testing_support::error_of;
using testing_support::has;

constexpr std::size_t kRain = 0, kTemperature = 1, kSunshine = 3, kWind = 4;

class WeatherFile : public ::testing::Test {
 protected:
  Weather csv(const std::string& text, TimeUnit unit = TimeUnit::Days) {
    write_atomically(folder_ / "rain.csv", text);
    return read_weather_csv(folder_ / "rain.csv", unit);
  }
  std::string says(const std::string& text) {
    return error_of([&] { (void)csv(text); });
  }
  Weather rows(const std::string& text) {
    const Json json = Json::parse(text);
    SceneContext context;
    context.add_input = [](const std::string&, const std::filesystem::path&) {};
    return read_weather(JsonReader((folder_ / "scene.json").string(), json, "/weather"), context, TimeUnit::Days);
  }
  std::string refuses(const std::string& text) {
    return error_of([&] { (void)rows(text); });
  }

  testing_support::TempFolder folder_;
};

TEST_F(WeatherFile, ATableHasItsColumnsInAnyOrderWithTheirUnits) {
  const Weather w =
      csv("# a station\n"
          "time (h), temperature (degC), rain (mm/h), sun (0..1), wind [m/s], wind_direction (deg)\r\n"
          "0, 11.5, 0, 1, 2, 270\r\n"
          "6, 9, 2.5, 0, 7, 180\r\n"
          "\n"
          "30, , 0, 0.5, 3, 90\n");
  ASSERT_EQ(w.rows.size(), 3u);
  EXPECT_EQ(w.rows[1].time, 0.25);  // days
  EXPECT_EQ(w.rows[1].values[kRain], 2.5);
  EXPECT_EQ(w.rows[0].values[kTemperature], 11.5);
  EXPECT_EQ(w.rows[2].values[kTemperature], 9.0);  // an empty cell: as above
  EXPECT_EQ(w.rows[2].values[kSunshine], 0.5);
  EXPECT_EQ(w.rows[1].values[kWind], 7.0);
  EXPECT_EQ(w.rows[2].wind_from_deg, 90.0);
  EXPECT_EQ(w.is_given, (std::array<bool, kNumWeatherSignals>{true, true, false, true, true}));
  EXPECT_EQ(csv("time (a), rain\n0, 1\n2, 0\n").rows[1].time, 2 * 365.25);
}

TEST_F(WeatherFile, EachFaultIsOneLineThatNamesIt) {
  EXPECT_TRUE(
      has(says("time (h), rain (mm/h)\n0, 1\n6, wet\n"), "rain.csv: line 3: `rain`: found `wet`; expected a number"));
  EXPECT_TRUE(has(says("time (h), rain (mm/h)\n6, 1\n3, 0\n"),
                  "line 3: the time of the weather is 0.125 after 0.25; rows go by time"));
  EXPECT_TRUE(has(says("time (h), rane (mm/h)\n0, 1\n"), "line 1: there is no column `rane`; use time, rain, "));
  EXPECT_TRUE(has(says("time (h), rane (mm/h)\n0, 1\n"), "did you mean `rain`?"));
  EXPECT_TRUE(has(says("time (h), rain (mm/h)\n0, -1\n"), "line 2: the rain is -1; use [0, 10000] mm/h"));
  EXPECT_TRUE(
      has(says("time, rain (mm/h)\n0, 1\n"), "the unit of `time`: use time (s), (min), (h), (d), (month) or (a)"));
  EXPECT_TRUE(has(says("time (h), rain (inch)\n0, 1\n"), "the unit of `rain (inch)`: use rain (mm/h)"));
  EXPECT_TRUE(has(says("time (h), rain, rain\n0, 1, 1\n"), "the column `rain` is there twice"));
  EXPECT_TRUE(has(says("rain (mm/h)\n1\n"), "a column `time` with a unit is missing"));
  EXPECT_TRUE(has(says("time (h)\n1\n"), "a column beside the time is missing"));
  EXPECT_TRUE(has(says("time (h), rain\n1\n"), "line 2: found 1 values; expected 2"));
  EXPECT_TRUE(has(says(""), "holds no weather"));
  EXPECT_TRUE(has(says("time (h), rain\n, 1\n"), "`time`: found ``; expected a number"));
}

TEST_F(WeatherFile, RowsOfASceneSayWhatChanges) {
  const Weather w =
      rows(R"([{"time": 0, "rain": 3, "temperature": 12}, {"time": "6 h", "rain": 0}, {"time": "1 month", "sun": 1}])");
  ASSERT_EQ(w.rows.size(), 3u);
  EXPECT_EQ(w.rows[1].time, 0.25);
  EXPECT_EQ(w.rows[1].values[kTemperature], 12.0);
  EXPECT_EQ(w.rows[2].time, 365.25 / 12);
  EXPECT_EQ(w.rows[2].values[kSunshine], 1.0);
  EXPECT_EQ(rows(R"({"rows": [{"time": 0, "rain": 3}], "repeat": "1 a"})").repeat, 365.25);
  write_atomically(folder_ / "rain.csv", "time (d), rain\n0, 1\n");
  EXPECT_EQ(rows(R"("rain.csv")").rows.size(), 1u);
  EXPECT_EQ(rows(R"({"file": "rain.csv", "repeat": 2})").repeat, 2.0);
}

TEST_F(WeatherFile, FaultsOfRowsNameThePlace) {
  EXPECT_TRUE(has(refuses(R"([{"time": 0, "rane": 3}])"), "/weather/0/rane: unknown key; did you mean `rain`?"));
  EXPECT_TRUE(
      has(refuses(R"([{"time": 2, "rain": 3}, {"time": 1}])"), "/weather/1: the time of the weather is 1 after 2"));
  EXPECT_TRUE(has(refuses(R"([{"time": 0, "rain": -3}])"), "/weather/0: the rain is -3"));
  EXPECT_TRUE(
      has(refuses(R"([{"time": "6 weeks", "rain": 3}])"), "/weather/0/time: found \"6 weeks\"; expected a time"));
  EXPECT_TRUE(has(refuses(R"([])"), "at least one row of weather"));
  EXPECT_TRUE(
      has(refuses(R"({"rows": [{"time": 3, "rain": 1}], "repeat": 3})"), "/weather: the weather repeats after 3"));
  EXPECT_TRUE(has(refuses(R"({"repeat": 3})"), "\"file\" or \"rows\""));
  EXPECT_TRUE(has(refuses("7"), "the path of a CSV"));
}

}  // namespace
}  // namespace patinate::simulation
