/// \file
/// When photographs were taken: from dates in their names, or from what the camera wrote into them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "patinate/history/history.h"

namespace patinate::capture {

/// Seconds from 1970-01-01 00:00:00 to a date and time in the proleptic Gregorian calendar, of no time zone; nothing if
/// there is no such date.
[[nodiscard]] std::optional<double> seconds_of_date(int year, int month, int day, int hour, int minute, int second);

/// First date in a file name: year, month, day, then perhaps hour, minute, second and (three digits at once)
/// milliseconds, e.g. `14_B_2020-05-28_18-20_U.png`, `IMG_20200528_182000.jpg`, `PXL_20200528_182000123.jpg`,
/// `2020-05-28.png`. Seconds since 1970.
[[nodiscard]] std::optional<double> time_in_name(const std::string& file_name);
/// EXIF "YYYY:MM:DD HH:MM:SS". Seconds since 1970.
[[nodiscard]] std::optional<double> time_in_exif(const std::string& date_time);

struct FrameTimes {
  std::vector<double> times;  ///< In the order of the photographs; from the earliest one, in `unit`; all different.
  std::string source;         ///< "dates in file names" or "EXIF".
};
/// Names first: image programs overwrite the date in a file when they save it, but keep its name. A source counts only
/// if it gives every photograph a time of its own.
/// @param photos,exif_dates  As many; "" = the photograph says nothing.
/// @throws InvalidInput saying what was tried, which photograph it failed for, and what to give instead.
[[nodiscard]] FrameTimes find_frame_times(const std::vector<std::filesystem::path>& photos,
                                          const std::vector<std::string>& exif_dates, TimeUnit unit);

}  // namespace patinate::capture
