#include "capture/project/frame_times.h"

#include <gtest/gtest.h>

#include <string>

#include "patinate/core/error.h"

namespace patinate::capture {
namespace {

TEST(FrameTimes, DatesCountFrom1970) {
  EXPECT_EQ(seconds_of_date(1970, 1, 1, 0, 0, 0), 0.0);
  EXPECT_EQ(seconds_of_date(2000, 3, 1, 0, 0, 0), 951868800.0);  // `date -u -d 2000-03-01 +%s`
  EXPECT_EQ(seconds_of_date(2020, 5, 28, 18, 20, 0), 1590690000.0);
  EXPECT_EQ(seconds_of_date(1969, 12, 31, 23, 59, 59), -1.0);
  EXPECT_FALSE(seconds_of_date(2021, 2, 29, 0, 0, 0));
  EXPECT_TRUE(seconds_of_date(2020, 2, 29, 0, 0, 0));
  EXPECT_FALSE(seconds_of_date(2020, 13, 1, 0, 0, 0));
  EXPECT_FALSE(seconds_of_date(2020, 1, 1, 24, 0, 0));
}

TEST(FrameTimes, FindsDatesInNames) {
  const auto at = [](int h, int m, int s) { return *seconds_of_date(2020, 5, 28, h, m, s); };
  EXPECT_EQ(time_in_name("14_B_2020-05-28_18-20_U.png"), at(18, 20, 0));
  EXPECT_EQ(time_in_name("IMG_20200528_182005.jpg"), at(18, 20, 5));
  EXPECT_EQ(time_in_name("2020-05-28T18:20:05.png"), at(18, 20, 5));
  EXPECT_EQ(time_in_name("20200528182005.png"), at(18, 20, 5));
  EXPECT_EQ(time_in_name("2020.05.28.png"), at(0, 0, 0));
  EXPECT_EQ(time_in_name("a2020_05_28b7.png"), at(0, 0, 0));
  EXPECT_FALSE(time_in_name("frame_0001.png"));
  EXPECT_FALSE(time_in_name("2020-13-28.png"));
  EXPECT_FALSE(time_in_name("12020052.png"));
  EXPECT_FALSE(time_in_name(""));
}

TEST(FrameTimes, MillisecondsMayFollowTheSeconds) {
  const double noon = *seconds_of_date(2020, 5, 28, 18, 20, 0);
  EXPECT_EQ(time_in_name("PXL_20200528_182000123.jpg"), noon + 0.123);
  EXPECT_EQ(time_in_name("20200528182000123.png"), noon + 0.123);
  EXPECT_EQ(time_in_name("PXL_20200528_1820001234.jpg"), *seconds_of_date(2020, 5, 28, 0, 0, 0));
  // Times since 1970 are so large that their difference is 0.12299990654.
  const FrameTimes found =
      find_frame_times({"PXL_20200528_182000123.jpg", "PXL_20200528_182000246.jpg"}, {"", ""}, TimeUnit::Seconds);
  EXPECT_EQ(found.times, (std::vector<double>{0.0, 0.123}));
}

TEST(FrameTimes, ReadsExifDates) {
  EXPECT_EQ(time_in_exif("2020:05:28 18:20:05"), *seconds_of_date(2020, 5, 28, 18, 20, 5));
  EXPECT_FALSE(time_in_exif(""));
  EXPECT_FALSE(time_in_exif("0000:00:00 00:00:00"));
  EXPECT_FALSE(time_in_exif("yesterday"));
}

TEST(FrameTimes, NamesComeBeforeExif) {
  const FrameTimes named = find_frame_times({"a_2020-01-03.png", "b_2020-01-01.png"},
                                            {"2021:01:01 00:00:00", "2021:01:01 01:00:00"}, TimeUnit::Days);
  EXPECT_EQ(named.source, "dates in file names");
  EXPECT_EQ(named.times, (std::vector<double>{2.0, 0.0}));
  const FrameTimes recorded =
      find_frame_times({"a.png", "b.png"}, {"2021:01:01 00:00:00", "2021:01:01 01:30:00"}, TimeUnit::Hours);
  EXPECT_EQ(recorded.source, "EXIF");
  EXPECT_EQ(recorded.times, (std::vector<double>{0.0, 1.5}));
}

TEST(FrameTimes, SayWhatWasTried) {
  try {
    (void)find_frame_times({"a_2020-01-01.png", "b_2020-01-01.png"}, {"2021:01:01 00:00:00", ""}, TimeUnit::Days);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_EQ(
        std::string(e.what()),
        "frames: no times; tried dates in file names (a_2020-01-01.png and b_2020-01-01.png have the same date in the "
        "name) and EXIF (b_2020-01-01.png has no EXIF date); give `interval`, or a list with times");
  }
}

}  // namespace
}  // namespace patinate::capture
