#include "capture/project/frame_times.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/error.h"

namespace patinate::capture {
namespace {

TEST(FrameTimes, DatesCountFrom1970) {
  EXPECT_EQ(seconds_of_date(1970, 1, 1, 0, 0, 0), 0);
  EXPECT_EQ(seconds_of_date(2000, 3, 1, 0, 0, 0), 951868800);  // `date -u -d 2000-03-01 +%s`
  EXPECT_EQ(seconds_of_date(2020, 5, 28, 18, 20, 0), 1590690000);
  EXPECT_EQ(seconds_of_date(1969, 12, 31, 23, 59, 59), -1);
  EXPECT_FALSE(seconds_of_date(2021, 2, 29, 0, 0, 0));
  EXPECT_TRUE(seconds_of_date(2020, 2, 29, 0, 0, 0));
  EXPECT_FALSE(seconds_of_date(2020, 13, 1, 0, 0, 0));
  EXPECT_EQ(seconds_of_date(2020, 1, 1, 24, 0, 0), seconds_of_date(2020, 1, 2, 0, 0, 0));  // ISO 8601.
  EXPECT_FALSE(seconds_of_date(2020, 1, 1, 24, 0, 1));
  EXPECT_FALSE(seconds_of_date(2020, 1, 1, 25, 0, 0));
}

std::string in_name(const std::string& name) {
  const std::optional<TimeStamp> found = times_in_names({name}).front();
  return found ? stamp_text(*found) : "";
}

std::string in_exif(const std::string& date) {
  const std::optional<TimeStamp> found = time_in_exif(date);
  return found ? stamp_text(*found) : "";
}

TEST(FrameTimes, FindsDatesInNames) {
  const std::pair<const char*, const char*> kNames[] = {
      {"14_B_2020-05-28_18-20_U", "2020-05-28 18:20"},
      {"IMG_20200528_182005", "2020-05-28 18:20:05"},
      {"2020-05-28T18:20:05", "2020-05-28 18:20:05"},
      {"20200528182005", "2020-05-28 18:20:05"},
      {"2020.05.28", "2020-05-28"},
      {"a2020_05_28b7", "2020-05-28"},
      {"frame_0001", ""},
      {"2020-13-28", ""},
      {"12020052", ""},
      {"", ""},
      {"PXL_20200528_182000123", "2020-05-28 18:20:00.123"},
      {"20200528182000123", "2020-05-28 18:20:00.123"},
      {"PXL_20200528_1820001234", ""},
      {"Screenshot 2020-05-28 at 1.20.05\xe2\x80\xafPM", "2020-05-28 13:20:05"},
      {"Picture 2020-05-28 12.20.05 AM", "2020-05-28 00:20:05"},
      {"Bildschirmfoto 2020-05-28 um 13.20.05", "2020-05-28 13:20:05"},
      {"28.05.2020 18-20-05.250", "2020-05-28 18:20:05.250"},
      {"05-28-2020_18-20-05", "2020-05-28 18:20:05"},
      {"06-05-2020_18-20-05", ""},
      {"28-05-2020_10-20", "2020-05-28 10:20"},
      {"28May2020_182005", "2020-05-28 18:20:05"},
      {"2020-05-28T18-20-05.25Z", "2020-05-28 18:20:05.25 +00:00"},
      {"2020-05-28T182005+0200", "2020-05-28 18:20:05 +02:00"},
      {"2020-05-28 (2)", "2020-05-28"},
      {"DSC_20101108", ""},
      {"20200528_0001", "2020-05-28"},
      {"IMG_20200528_182005_001", "2020-05-28 18:20:05"},
  };
  for (const auto& [name, expected] : kNames) EXPECT_EQ(in_name(name), expected) << name;
}

// A counter runs through numbers that are no dates: 20101131.
TEST(FrameTimes, EightDigitsAreADateWhereTheyLieInSeveralMonths) {
  EXPECT_FALSE(times_in_names({"DSC_20101108", "DSC_20101109"})[0]);
  EXPECT_TRUE(times_in_names({"DSC_20101130", "DSC_20101201"})[0]);
}

TEST(FrameTimes, DayAndMonthAreToldApartByAllNames) {
  const auto found = times_in_names({"06-05-2020 10.20", "28-05-2020 10.20"});
  ASSERT_TRUE(found[0] && found[1]);
  EXPECT_EQ(stamp_text(*found[0]), "2020-05-06 10:20");
}

TEST(FrameTimes, ReadsExifDates) {
  EXPECT_EQ(in_exif("2020:05:28 18:20:05"), "2020-05-28 18:20:05");
  EXPECT_EQ(in_exif("2023:03:26 01:30:00.25+01:00"), "2023-03-26 01:30:00.25 +01:00");
  EXPECT_EQ(in_exif("1969:12:31 23:59:59"), "1969-12-31 23:59:59");
  EXPECT_EQ(in_exif(""), "");
  EXPECT_EQ(in_exif("0000:00:00 00:00:00"), "");
  EXPECT_EQ(in_exif("2020:05:28   :  :  "), "");
  EXPECT_EQ(in_exif("yesterday"), "");
}

TEST(FrameTimes, ExifComesBeforeNamesAndTheFinestOfThoseThatAgreeIsTaken) {
  const FrameTimes both = find_frame_times(
      {{"a_2020-01-03.png", "2020:01:03 08:00:00"}, {"b_2020-01-01.png", "2020:01:01 20:00:00"}}, TimeUnit::Hours);
  EXPECT_EQ(both.source, "EXIF DateTimeOriginal");
  EXPECT_EQ(both.times, (std::vector<double>{36.0, 0.0}));
  EXPECT_TRUE(both.warnings.empty());
  const FrameTimes named = find_frame_times({{"a_2020-01-03.png"}, {"b_2020-01-01.png"}}, TimeUnit::Days);
  EXPECT_EQ(named.source, "dates in file names");
  EXPECT_EQ(named.times, (std::vector<double>{2.0, 0.0}));
  // Times since 1970 as floating-point numbers would differ by 0.12299990654.
  const FrameTimes fine = find_frame_times(
      {{"PXL_20200528_182000123.jpg", "2020:05:28 20:20:00"}, {"PXL_20200528_182000246.jpg", "2020:05:28 20:20:00"}},
      TimeUnit::Seconds);
  EXPECT_EQ(fine.source, "dates in file names");
  EXPECT_EQ(fine.times, (std::vector<double>{0.0, 0.123}));
  EXPECT_TRUE(fine.warnings.empty());
}

TEST(FrameTimes, SourcesThatDisagreeAreNamed) {
  const FrameTimes found = find_frame_times(
      {{"2020-05-28_10-00.png", "2020:05:28 10:00:00"}, {"2020-05-28_11-00.png", "2020:05:28 13:00:00"}},
      TimeUnit::Hours);
  EXPECT_EQ(found.times, (std::vector<double>{0.0, 3.0}));
  ASSERT_EQ(found.warnings.size(), 1u);
  EXPECT_NE(found.warnings[0].text.find("2020-05-28 13:00:00 by EXIF DateTimeOriginal"), std::string::npos)
      << found.warnings[0].text;
  EXPECT_NE(found.warnings[0].text.find("2020-05-28 11:00 by dates in file names"), std::string::npos);
}

TEST(FrameTimes, ExcludedPhotographsSayWhenTheSeriesBegins) {
  const FrameTimes found = find_frame_times({{"2020-01-01.png", "", "", false}, {"2020-01-03.png"}}, TimeUnit::Days);
  EXPECT_EQ(found.times, (std::vector<double>{2.0}));
}

TEST(FrameTimes, SayWhatWasTried) {
  try {
    (void)find_frame_times({{"a_2020-01-01.png", "2021:01:01 00:00:00"}, {"b_2020-01-01.png"}}, TimeUnit::Days);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_EQ(std::string(e.what()),
              "frames: no times; tried EXIF DateTimeOriginal (b_2020-01-01.png has no EXIF DateTimeOriginal), EXIF "
              "DateTimeDigitized (a_2020-01-01.png has no EXIF DateTimeDigitized) and dates in file names "
              "(a_2020-01-01.png and b_2020-01-01.png have the same date in the name); give `interval`, or a list with "
              "times");
  }
}

}  // namespace
}  // namespace patinate::capture
