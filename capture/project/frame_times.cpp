#include "capture/project/frame_times.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

/// Reads numbers of a fixed width with optional separators between them.
class DigitReader {
 public:
  DigitReader(const std::string& text, std::size_t at) : text_(text), at_(at) {}

  std::optional<int> digits(int count) {
    int value = 0;
    for (int i = 0; i < count; ++i) {
      const std::size_t k = at_ + static_cast<std::size_t>(i);
      if (k >= text_.size() || !is_digit(text_[k])) return std::nullopt;
      value = 10 * value + (text_[k] - '0');
    }
    at_ += static_cast<std::size_t>(count);
    return value;
  }
  void skip(const std::string& separators) {
    if (at_ < text_.size() && separators.find(text_[at_]) != std::string::npos) ++at_;
  }
  [[nodiscard]] bool is_at_digit() const { return at_ < text_.size() && is_digit(text_[at_]); }

 private:
  const std::string& text_;
  std::size_t at_;
};

/// A date, perhaps with a time, that starts exactly at `at`.
std::optional<double> date_at(const std::string& text, std::size_t at) {
  DigitReader reader(text, at);
  const auto year = reader.digits(4);
  reader.skip("-_.");
  const auto month = reader.digits(2);
  reader.skip("-_.");
  const auto day = reader.digits(2);
  if (!year || !month || !day || *year < 1800 || *year > 2200) return std::nullopt;
  const std::optional<double> date = seconds_of_date(*year, *month, *day, 0, 0, 0);
  if (!date) return std::nullopt;
  DigitReader time = reader;
  time.skip("-_. T");
  const auto hour = time.digits(2);
  time.skip("-_.:h");
  const auto minute = time.digits(2);
  if (!hour || !minute) return reader.is_at_digit() ? std::nullopt : date;
  DigitReader rest = time;
  rest.skip("-_.:m");
  const auto second = rest.digits(2);
  const auto millisecond = rest.is_at_digit() ? rest.digits(3) : 0;
  const bool has_second = second && millisecond && !rest.is_at_digit();
  if (!has_second && time.is_at_digit()) return date;
  const auto exact = seconds_of_date(*year, *month, *day, *hour, *minute, has_second ? *second : 0);
  if (!exact) return date;
  return has_second ? *exact + *millisecond / 1000.0 : *exact;
}

/// Why a source of times cannot be used; "" when it can.
std::string problem_with(const std::vector<std::optional<double>>& times,
                         const std::vector<std::filesystem::path>& photos, const std::string& what) {
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!times[i]) return photos[i].filename().string() + " has no " + what;
  }
  std::vector<std::size_t> order(times.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return *times[a] < *times[b]; });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (*times[order[i - 1]] == *times[order[i]]) {
      return photos[order[i - 1]].filename().string() + " and " + photos[order[i]].filename().string() +
             " have the same " + what;
    }
  }
  return "";
}

std::vector<double> relative_times(const std::vector<std::optional<double>>& times, TimeUnit unit) {
  double first = *times.front();
  for (const auto& t : times) first = std::min(first, *t);
  std::vector<double> result;
  for (const auto& t : times) {
    const double milliseconds = std::round((*t - first) * 1000.0);  // Seconds since 1970 have no exact fractions.
    result.push_back(milliseconds / 1000.0 / seconds_per(unit));
  }
  return result;
}

}  // namespace

std::optional<double> seconds_of_date(int year, int month, int day, int hour, int minute, int second) {
  constexpr int kDays[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  if (month < 1 || month > 12) return std::nullopt;
  const bool is_leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  const int days_in_month = kDays[month - 1] + (month == 2 && is_leap ? 1 : 0);
  const bool is_time = hour >= 0 && hour < 24 && minute >= 0 && minute < 60 && second >= 0 && second < 61;
  if (day < 1 || day > days_in_month || !is_time) return std::nullopt;
  // Days since 1970-01-01 by counting years from March, so that the leap day comes last.
  const int y = month <= 2 ? year - 1 : year;
  const int day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const int days = 365 * y + y / 4 - y / 100 + y / 400 + day_of_year - 719468;
  return 86400.0 * days + 3600.0 * hour + 60.0 * minute + second;
}

std::optional<double> time_in_name(const std::string& file_name) {
  for (std::size_t at = 0; at < file_name.size(); ++at) {
    if (!is_digit(file_name[at]) || (at > 0 && is_digit(file_name[at - 1]))) continue;
    if (const auto time = date_at(file_name, at)) return time;
  }
  return std::nullopt;
}

std::optional<double> time_in_exif(const std::string& date_time) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  const int num_read = std::sscanf(date_time.c_str(), "%4d%*1[:-]%2d%*1[:-]%2d%*1[ T]%2d:%2d:%2d", &year, &month, &day,
                                   &hour, &minute, &second);
  if (num_read < 5) return std::nullopt;
  return seconds_of_date(year, month, day, hour, minute, second);
}

FrameTimes find_frame_times(const std::vector<std::filesystem::path>& photos,
                            const std::vector<std::string>& exif_dates, TimeUnit unit) {
  if (photos.empty() || photos.size() != exif_dates.size()) throw InvalidInput("frames: there is no photograph");
  std::vector<std::optional<double>> named, recorded;
  for (const auto& photo : photos) named.push_back(time_in_name(photo.filename().string()));
  for (const std::string& date : exif_dates) recorded.push_back(time_in_exif(date));
  const std::string name_problem = problem_with(named, photos, "date in the name");
  if (name_problem.empty()) return {relative_times(named, unit), "dates in file names"};
  const std::string exif_problem = problem_with(recorded, photos, "EXIF date");
  if (exif_problem.empty()) return {relative_times(recorded, unit), "EXIF"};
  throw InvalidInput("frames: no times; tried dates in file names (" + name_problem + ") and EXIF (" + exif_problem +
                     "); give `interval`, or a list with times");
}

}  // namespace patinate::capture
