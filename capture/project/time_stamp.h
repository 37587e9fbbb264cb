/// \file
/// Dates with a time of day as photographs carry them: in EXIF, and in the names of files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace patinate::capture {

/// Reading of a clock.
struct TimeStamp {
  std::int64_t clock_us = 0;           ///< Microseconds from 1970-01-01 00:00 of that clock on.
  std::int64_t resolution_us = 0;      ///< The time lies in [clock_us, clock_us + resolution_us); > 0.
  std::optional<int> offset_min = {};  ///< Offset of the clock from UTC, where it is said.

  friend bool operator==(const TimeStamp&, const TimeStamp&) = default;
};
inline constexpr std::int64_t kSecond_us = 1'000'000;
inline constexpr std::int64_t kMinute_us = 60 * kSecond_us;
inline constexpr std::int64_t kHour_us = 60 * kMinute_us;
inline constexpr std::int64_t kDay_us = 24 * kHour_us;

/// "2023-03-26 01:30:00.25 +01:00", without what is not known.
[[nodiscard]] std::string stamp_text(const TimeStamp& stamp);

/// Whether a clock shows it: leap seconds count, and 24:00:00 is the end of a day [ISO 8601].
[[nodiscard]] bool is_time_of_day(int hour, int minute, int second);
/// Seconds from 1970-01-01 00:00:00 to a date and time in the proleptic Gregorian calendar; nothing if there is no such
/// date.
[[nodiscard]] std::optional<std::int64_t> seconds_of_date(int year, int month, int day, int hour, int minute,
                                                          int second);

/// "YYYY:MM:DD HH:MM[:SS[.SSSSSS]][+HH:MM]", with `-` or `T` as XMP has them. Nothing where the time of day is missing.
[[nodiscard]] std::optional<TimeStamp> time_in_exif(const std::string& date_time);

/// Dates in the names of the photographs of one series, most with a time of day: `14_B_2020-05-28_18-20_U.png`,
/// `PXL_20200528_182000123.jpg`, `Screenshot 2020-05-28 at 1.20.05 PM.png`, `28.05.2020 18-20-05.250.jpg`.
///
/// What may as well count the photographs is no date: eight digits without a time of day, as long as all of them lie in
/// one month; digits without separators behind a date that all begin with 00; three digits behind the seconds of which
/// none is larger than the number of photographs. Day and month are told apart by what is a date in every name.
/// @returns as many as names; nothing for a name without a date.
[[nodiscard]] std::vector<std::optional<TimeStamp>> times_in_names(const std::vector<std::string>& names);

}  // namespace patinate::capture
