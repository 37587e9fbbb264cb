#include "capture/project/time_stamp.h"

#include <array>
#include <cstdio>
#include <cstdlib>

#include "libcommon/core/text.h"

namespace patinate::capture {

std::string stamp_text(const TimeStamp& stamp) {
  const std::int64_t day =
      stamp.clock_us >= 0 ? stamp.clock_us / kDay_us : -((-stamp.clock_us + kDay_us - 1) / kDay_us);
  const std::int64_t of_day = stamp.clock_us - day * kDay_us;
  // Days from 0000-03-01 on, in eras of 400 years.
  const std::int64_t shifted = day + 719468, era = shifted / 146097, in_era = shifted % 146097;
  const std::int64_t year_of_era = (in_era - in_era / 1460 + in_era / 36524 - in_era / 146096) / 365;
  const std::int64_t in_year = in_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
  const std::int64_t march = (5 * in_year + 2) / 153;
  const int month = static_cast<int>(march < 10 ? march + 3 : march - 9);
  const int year = static_cast<int>(400 * era + year_of_era + (month <= 2 ? 1 : 0));
  std::array<char, 64> text{};
  (void)std::snprintf(text.data(), text.size(), "%04d-%02d-%02d", year, month,
                      static_cast<int>(in_year - (153 * march + 2) / 5 + 1));
  std::string out = text.data();
  if (stamp.resolution_us >= kDay_us) return out;
  (void)std::snprintf(text.data(), text.size(), " %02d:%02d", static_cast<int>(of_day / kHour_us),
                      static_cast<int>(of_day / kMinute_us % 60));
  out += text.data();
  if (stamp.resolution_us < kMinute_us) {
    (void)std::snprintf(text.data(), text.size(), ":%02d", static_cast<int>(of_day / kSecond_us % 60));
    out += text.data();
  }
  if (stamp.resolution_us < kSecond_us) {
    std::string fraction = zero_padded(static_cast<std::uint64_t>(of_day % kSecond_us), 6);
    std::int64_t unit = stamp.resolution_us;
    while (unit >= 10 && fraction.size() > 1) fraction.pop_back(), unit /= 10;
    out += "." + fraction;
  }
  if (stamp.offset_min) {
    const int size = std::abs(*stamp.offset_min);
    (void)std::snprintf(text.data(), text.size(), " %c%02d:%02d", *stamp.offset_min < 0 ? '-' : '+', size / 60,
                        size % 60);
    out += text.data();
  }
  return out;
}

bool is_time_of_day(int hour, int minute, int second) {
  if (hour == 24) return minute == 0 && second == 0;
  return hour >= 0 && hour < 24 && minute >= 0 && minute < 60 && second >= 0 && second < 61;
}

std::optional<std::int64_t> seconds_of_date(int year, int month, int day, int hour, int minute, int second) {
  constexpr int kDays[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  if (month < 1 || month > 12) return std::nullopt;
  const bool is_leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  const int days_in_month = kDays[month - 1] + (month == 2 && is_leap ? 1 : 0);
  if (day < 1 || day > days_in_month || !is_time_of_day(hour, minute, second)) return std::nullopt;
  // Days since 1970-01-01 by counting years from March, so that the leap day comes last.
  const int y = month <= 2 ? year - 1 : year;
  const int day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const std::int64_t days = 365 * std::int64_t{y} + y / 4 - y / 100 + y / 400 + day_of_year - 719468;
  return 86400 * days + 3600 * hour + 60 * minute + second;
}

}  // namespace patinate::capture
