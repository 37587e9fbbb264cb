// Dates as people and programs write them: read from names of files and from EXIF.
#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <set>
#include <string_view>
#include <utility>

#include "capture/project/time_stamp.h"
#include "libcommon/core/text.h"

namespace patinate::capture {

namespace {

/// Reads a text from left to right.
class TextReader {
 public:
  TextReader(std::string_view text, std::size_t at) : text_(text), at_(at) {}

  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] char next() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  [[nodiscard]] bool is_at_letter() const { return std::isalpha(static_cast<unsigned char>(next())) != 0; }
  /// Digits that follow one another here.
  [[nodiscard]] int num_digits() const {
    std::size_t end = at_;
    while (end < text_.size() && is_digit(text_[end])) ++end;
    return static_cast<int>(std::min<std::size_t>(end - at_, 32));
  }
  /// A number of exactly so many digits; nothing, and no step, where there are fewer.
  std::optional<int> number(int digits) {
    if (digits < 1 || num_digits() < digits) return std::nullopt;
    int value = 0;
    for (int i = 0; i < digits; ++i) value = 10 * value + (text_[at_++] - '0');
    return value;
  }
  bool skip(std::string_view word) {
    if (word.empty() || text_.substr(at_, word.size()) != word) return false;
    at_ += word.size();
    return true;
  }
  void step() { ++at_; }
  /// The character here, if it is one of these; it is stepped over.
  std::optional<char> one_of(std::string_view characters) {
    if (next() == '\0' || characters.find(next()) == std::string_view::npos) return std::nullopt;
    return text_[at_++];
  }

 private:
  std::string_view text_;
  std::size_t at_;
};

constexpr std::array<std::string_view, 12> kMonths{"jan", "feb", "mar", "apr", "may", "jun",
                                                   "jul", "aug", "sep", "oct", "nov", "dec"};

/// One or two digits.
std::optional<int> short_number(TextReader& reader) {
  const int digits = reader.num_digits();
  return digits == 1 || digits == 2 ? reader.number(digits) : std::nullopt;
}

/// Statement of a name, before the other names are known.
struct NamedTime {
  int year = 0, month = 0, day = 0;
  bool is_year_last = false;  ///< Day and month may have to be exchanged.
  bool is_month_named = false;
  bool is_compact = false;                  ///< Eight digits in a row.
  int hour = -1, minute = -1, second = -1;  ///< -1 = not said.
  bool is_time_compact = false;             ///< Four or more digits in a row.
  int fraction_us = 0;
  int fraction_digits = 0;
  bool is_fraction_apart = false;  ///< Three digits behind `-` or `_`: milliseconds, or a counter.
  std::optional<int> offset_min = {};

  [[nodiscard]] std::optional<std::int64_t> seconds() const {
    return seconds_of_date(year, month, day, std::max(hour, 0), std::max(minute, 0), std::max(second, 0));
  }
  [[nodiscard]] bool has_time_of_day() const { return is_time_of_day(hour, std::max(minute, 0), std::max(second, 0)); }
};

std::optional<int> month_number(TextReader& reader, bool& is_named) {
  for (std::size_t m = 0; m < kMonths.size(); ++m) {
    TextReader word = reader;
    if (!word.skip(kMonths[m]) || word.is_at_letter()) continue;
    reader = word;
    is_named = true;
    return static_cast<int>(m) + 1;
  }
  return short_number(reader);
}

constexpr std::string_view kDateSeparators = "-_. :";

/// 20200528, 2020-05-28, 2020-May-28.
bool read_year_first(TextReader& reader, NamedTime& out) {
  TextReader r = reader;
  const auto year = r.number(4);
  if (!year) return false;
  const auto separator = r.one_of(kDateSeparators);
  const auto month = separator ? month_number(r, out.is_month_named) : r.number(2);
  if (separator && r.one_of(std::string_view(&*separator, 1)) != separator) return false;
  const auto day = separator ? short_number(r) : r.number(2);
  if (!month || !day) return false;
  out.year = *year, out.month = *month, out.day = *day;
  out.is_compact = !separator;
  reader = r;
  return true;
}

/// 28-05-2020, 28.5.2020, 28 May 2020, 28May2020; 05-28-2020.
bool read_year_last(TextReader& reader, NamedTime& out) {
  TextReader r = reader;
  const auto day = short_number(r);
  const auto separator = r.one_of(kDateSeparators);
  const auto month = month_number(r, out.is_month_named);
  if (!day || !month || (!separator && !out.is_month_named)) return false;
  if (separator && r.one_of(std::string_view(&*separator, 1)) != separator) return false;
  const auto year = r.num_digits() == 4 ? r.number(4) : std::nullopt;
  if (!year) return false;
  out.year = *year, out.month = *month, out.day = *day;
  out.is_year_last = true;
  reader = r;
  return true;
}

/// AM or PM here, perhaps behind a blank. @returns hours to add to a 12-hour clock's hour, and -1 where there is none
int read_half_day(TextReader& reader) {
  TextReader r = reader;
  (void)r.one_of(" _-.");
  const auto half = r.one_of("ap");
  (void)r.one_of(".");
  if (!half || !r.one_of("m") || r.is_at_letter()) return -1;
  reader = r;
  return *half == 'p' ? 12 : 0;
}

void read_fraction(TextReader& reader, NamedTime& out) {
  TextReader r = reader;
  const auto separator = r.one_of(".,-_");
  const int digits = r.num_digits();
  const bool is_apart = separator == '-' || separator == '_';
  if (!separator || (is_apart ? digits != 3 : digits < 1 || digits > 6)) return;
  out.fraction_us = *r.number(digits);
  out.fraction_digits = digits;
  out.is_fraction_apart = is_apart;
  for (int i = digits; i < 6; ++i) out.fraction_us *= 10;
  reader = r;
}

/// "Z", "+02:00", "-0500": whole quarters of an hour.
std::optional<int> read_offset(TextReader& reader) {
  TextReader r = reader;
  (void)r.one_of(" ");
  if (r.one_of("zZ")) {
    if (r.is_at_letter() || is_digit(r.next())) return std::nullopt;
    reader = r;
    return 0;
  }
  const auto sign = r.one_of("+-");
  const auto hours = r.number(2);
  (void)r.one_of(":");
  const auto minutes = r.number(2);
  constexpr int kMaxHours = 14;  // UTC+14 is the largest offset.
  if (!sign || !hours || !minutes || *hours > kMaxHours || *minutes % 15 != 0 || is_digit(r.next()))
    return std::nullopt;
  reader = r;
  return (*sign == '-' ? -1 : 1) * (60 * *hours + *minutes);
}

/// Skips what may stand between date and time: up to three separators, or a word between blanks, as in "... at 1.20.05
/// PM".
void skip_to_time(TextReader& reader) {
  TextReader word = reader;
  if (word.one_of(" _")) {
    int length = 0;
    for (; word.is_at_letter() || (word.next() & 0x80) != 0; ++length) word.step();
    constexpr int kLongest = 6;
    if (length > 0 && length <= kLongest && word.one_of(" _") && is_digit(word.next())) {
      reader = word;
      return;
    }
  }
  for (int i = 0; i < 3 && reader.one_of("-_. ,@(t"); ++i) {
  }
}

/// 182005, 182005123, 1820: digits in a row.
bool read_compact_time(TextReader& r, NamedTime& out) {
  const int digits = r.num_digits();
  if (digits != 4 && digits != 6 && digits != 8 && digits != 9) return false;
  TextReader date = r;
  NamedTime other;
  if (digits == 8 && read_year_first(date, other) && other.seconds()) return false;  // The second date of a name.
  out.hour = *r.number(2), out.minute = *r.number(2);
  out.is_time_compact = true;
  if (digits >= 6) out.second = *r.number(2);
  if (digits <= 6) return true;
  out.fraction_digits = digits - 6;
  out.fraction_us = *r.number(digits - 6) * (digits == 8 ? 10'000 : 1'000);
  return true;
}

/// 18-20-05, 18.20, 18h20m05, 1.20 before PM.
bool read_separated_time(TextReader& r, NamedTime& out) {
  const auto hour = short_number(r);
  if (!hour) return false;
  out.hour = *hour;
  TextReader more = r;
  const auto separator = more.one_of("-_.: h");
  if (!separator || more.num_digits() != 2) return true;
  out.minute = *more.number(2);
  r = more;
  const std::string_view next = *separator == 'h' ? std::string_view("m") : std::string_view(&*separator, 1);
  if (!more.one_of(next) || more.num_digits() != 2) return true;
  out.second = *more.number(2);
  (void)more.one_of("s");
  r = more;
  return true;
}

/// The time of day behind a date; nothing is changed where there is none.
void read_time(TextReader& reader, NamedTime& out) {
  TextReader r = reader;
  skip_to_time(r);
  NamedTime timed = out;
  if (!read_compact_time(r, timed) && !read_separated_time(r, timed)) return;
  if (timed.second >= 0 && timed.fraction_digits == 0) read_fraction(r, timed);
  if (const int added = read_half_day(r); added >= 0) {
    if (timed.hour < 1 || timed.hour > 12) return;
    timed.hour = timed.hour % 12 + added;
  } else if (timed.minute < 0) {
    return;  // A number alone is no time of day.
  }
  if (!timed.has_time_of_day()) return;
  timed.offset_min = read_offset(r);
  out = timed;
  reader = r;
}

/// A date that starts at `at` in a name of small letters, and where it ends.
std::optional<std::pair<NamedTime, std::size_t>> named_time_at(const std::string& name, std::size_t at) {
  TextReader reader(name, at);
  NamedTime out;
  if (!read_year_first(reader, out)) {
    out = {};
    if (!read_year_last(reader, out)) return std::nullopt;
  }
  NamedTime exchanged = out;
  std::swap(exchanged.day, exchanged.month);
  const bool is_date = out.seconds() || (out.is_year_last && !out.is_month_named && exchanged.seconds());
  if (!is_date || out.year < 1800 || out.year > 2200) return std::nullopt;
  if (out.is_compact && is_digit(reader.next())) {
    // All digits in a row, down to the seconds or further.
    const int digits = reader.num_digits();
    if (digits < 4 || !read_compact_time(reader, out)) return std::nullopt;
    if (!out.has_time_of_day()) return std::nullopt;
  } else if (is_digit(reader.next())) {
    return std::nullopt;
  } else {
    read_time(reader, out);
  }
  return std::pair{out, reader.at()};
}

/// Small letters, and every kind of blank as one.
std::string plain_name(const std::string& name) {
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto is_here = [&](std::string_view bytes) { return name.compare(i, bytes.size(), bytes) == 0; };
    if (is_here("\xe2\x80\xaf") || is_here("\xc2\xa0")) {  // Narrow and plain no-break space.
      plain += ' ';
      i += is_here("\xc2\xa0") ? 1 : 2;
    } else {
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
    }
  }
  return plain;
}

/// The first date with a time of day; else the first with separators; else the first.
std::optional<NamedTime> named_time(const std::string& file_name) {
  const std::string name = plain_name(file_name);
  const auto rank = [](const NamedTime& t) { return t.hour >= 0 ? 2 : t.is_compact ? 0 : 1; };
  std::optional<NamedTime> best;
  for (std::size_t at = 0; at < name.size(); ++at) {
    if (!is_digit(name[at]) || (at > 0 && is_digit(name[at - 1]))) continue;
    const auto found = named_time_at(name, at);
    if (!found) continue;
    if (!best || rank(found->first) > rank(*best)) best = found->first;
    at = found->second - 1;
  }
  return best;
}

using NamedTimes = std::vector<std::optional<NamedTime>>;

template <class Choice>
bool all_of_those(const NamedTimes& times, const Choice& is_meant, const std::function<bool(const NamedTime&)>& test) {
  return std::all_of(times.begin(), times.end(), [&](const auto& t) { return !t || !is_meant(*t) || test(*t); });
}

/// Puts day and month into their places; dates that can be read both ways are dropped.
void tell_day_and_month(NamedTimes& times) {
  const auto is_open = [](const NamedTime& t) { return t.is_year_last && !t.is_month_named; };
  const auto exchanged = [](NamedTime t) {
    std::swap(t.day, t.month);
    return t;
  };
  const bool is_day_first = all_of_those(times, is_open, [](const NamedTime& t) { return t.seconds().has_value(); });
  const bool is_month_first =
      all_of_those(times, is_open, [&](const NamedTime& t) { return exchanged(t).seconds().has_value(); });
  for (auto& t : times) {
    if (!t || !is_open(*t)) continue;
    if (is_day_first == is_month_first && t->day != t->month)
      t.reset();
    else if (is_month_first)
      t = exchanged(*t);
  }
}

/// Drops what may as well count the photographs.
void drop_counters(NamedTimes& times) {
  const auto is_date_alone = [](const NamedTime& t) { return t.is_compact && t.hour < 0; };
  std::set<std::pair<int, int>> months;
  for (const auto& t : times) {
    if (t && is_date_alone(*t)) months.emplace(t->year, t->month);
  }
  const auto is_row = [](const NamedTime& t) { return t.is_time_compact; };
  const bool are_rows_counted =
      all_of_those(times, is_row, [](const NamedTime& t) { return t.hour == 0 && (t.second < 0 || t.minute == 0); });
  const auto is_apart = [](const NamedTime& t) { return t.is_fraction_apart; };
  const bool are_fractions_counted = all_of_those(
      times, is_apart, [&](const NamedTime& t) { return t.fraction_us / 1000 <= static_cast<int>(times.size()); });
  for (auto& t : times) {
    if (t && is_date_alone(*t) && months.size() < 2) t.reset();
    if (t && is_row(*t) && are_rows_counted) t->hour = t->minute = t->second = -1, t->fraction_digits = 0;
    if (t && is_apart(*t) && are_fractions_counted) t->fraction_digits = 0, t->fraction_us = 0;
  }
}

TimeStamp stamp_of(const NamedTime& t) {
  std::int64_t resolution = t.hour < 0 ? kDay_us : t.minute < 0 ? kHour_us : t.second < 0 ? kMinute_us : kSecond_us;
  if (t.hour >= 0 && t.second >= 0)
    for (int i = 0; i < t.fraction_digits; ++i) resolution /= 10;
  return {*t.seconds() * kSecond_us + (t.fraction_digits > 0 ? t.fraction_us : 0), resolution, t.offset_min};
}

}  // namespace

std::optional<TimeStamp> time_in_exif(const std::string& date_time) {
  TextReader r(date_time, 0);
  const auto separated = [&](std::string_view separators) { return r.one_of(separators) ? r.number(2) : std::nullopt; };
  const auto year = r.number(4), month = separated(":-"), day = separated(":-"), hour = separated(" T"),
             minute = separated(":");
  if (!year || !month || !day || !hour || !minute) return std::nullopt;
  TimeStamp stamp{0, kMinute_us, {}};
  const auto second = separated(":");
  const auto seconds = seconds_of_date(*year, *month, *day, *hour, *minute, second.value_or(0));
  if (!seconds) return std::nullopt;
  stamp.clock_us = *seconds * kSecond_us;
  if (second) stamp.resolution_us = kSecond_us;
  if (second && r.one_of(".,")) {
    for (std::int64_t unit = kSecond_us / 10; is_digit(r.next()); unit /= 10) {
      stamp.clock_us += unit * *r.number(1);  // Digits behind the microseconds count for nothing.
      if (unit > 0) stamp.resolution_us = unit;
    }
  }
  stamp.offset_min = read_offset(r);
  return stamp;
}

std::vector<std::optional<TimeStamp>> times_in_names(const std::vector<std::string>& names) {
  NamedTimes times;
  for (const std::string& name : names) times.push_back(named_time(name));
  tell_day_and_month(times);
  drop_counters(times);
  std::vector<std::optional<TimeStamp>> stamps;
  for (const auto& t : times) stamps.push_back(t ? std::optional(stamp_of(*t)) : std::nullopt);
  return stamps;
}

}  // namespace patinate::capture
