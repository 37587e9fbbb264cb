#include "capture/project/frame_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

using Stamps = std::vector<std::optional<TimeStamp>>;

/// Times of every photograph by one source.
struct TimeSource {
  std::string name;     ///< "EXIF DateTimeOriginal".
  std::string missing;  ///< Missing item of a photograph: "EXIF DateTimeOriginal", "date in the name".
  Stamps stamps;
  std::string DatedPhoto::*text = nullptr;  ///< Member that is read, where it is no name.
  std::string problem = "";                 ///< Why it cannot be used; "" when it can.

  [[nodiscard]] bool says_something() const {
    return std::any_of(stamps.begin(), stamps.end(), [](const auto& s) { return s.has_value(); });
  }
};

/// Offsets of the photographs that are kept: none, the same everywhere, different ones, or not known of all.
enum class Offsets { Same, Different, Unknown };

Offsets offsets_of(const Stamps& stamps, const std::vector<DatedPhoto>& photos) {
  std::set<std::optional<int>> found;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (photos[i].is_kept && stamps[i]) found.insert(stamps[i]->offset_min);
  }
  if (found.size() <= 1) return Offsets::Same;
  return found.size() == 2 && found.contains(std::nullopt) ? Offsets::Same
         : found.contains(std::nullopt)                    ? Offsets::Unknown
                                                           : Offsets::Different;
}

std::int64_t utc_us(const TimeStamp& stamp) { return stamp.clock_us - stamp.offset_min.value_or(0) * kMinute_us; }

/// Times on one scale, in microseconds; nothing where they are not known on it.
std::vector<std::optional<std::int64_t>> moments_of(const Stamps& stamps, const std::vector<DatedPhoto>& photos) {
  const bool is_utc = offsets_of(stamps, photos) == Offsets::Different;
  std::vector<std::optional<std::int64_t>> moments;
  for (const auto& s : stamps) {
    const bool is_known = s && (!is_utc || s->offset_min);
    moments.push_back(!is_known ? std::nullopt : std::optional(is_utc ? utc_us(*s) : s->clock_us));
  }
  return moments;
}

std::string file_name(const DatedPhoto& photo) { return photo.file.filename().string(); }

/// Why a source cannot be used; "" when it can.
std::string problem_with(const TimeSource& source, const std::vector<DatedPhoto>& photos) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].is_kept) continue;
    if (source.stamps[i]) {
      order.push_back(i);
      continue;
    }
    const std::string said = source.text == nullptr ? "" : photos[i].*source.text;
    return file_name(photos[i]) + " has no " + source.missing + (said.empty() ? "" : " that is a date: `" + said + "`");
  }
  const auto is_day = [&](std::size_t i) { return source.stamps[i]->resolution_us >= kDay_us; };
  const auto day = std::find_if(order.begin(), order.end(), is_day);
  const auto timed = std::find_if_not(order.begin(), order.end(), is_day);
  if (day != order.end() && timed != order.end())
    return file_name(photos[*timed]) + " has a time of day in its " + source.missing + ", " + file_name(photos[*day]) +
           " none";
  if (offsets_of(source.stamps, photos) == Offsets::Unknown) {
    const auto silent =
        std::find_if(order.begin(), order.end(), [&](std::size_t i) { return !source.stamps[i]->offset_min; });
    return file_name(photos[*silent]) + " has no OffsetTime, which changes in the series";
  }
  const auto moments = moments_of(source.stamps, photos);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return *moments[a] < *moments[b]; });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (moments[order[i - 1]] == moments[order[i]])
      return file_name(photos[order[i - 1]]) + " and " + file_name(photos[order[i]]) + " have the same " +
             source.missing;
  }
  return "";
}

/// A clock that shows no fraction of a second writes zeros where one is asked for.
void coarsen(Stamps& stamps) {
  const bool has_fraction =
      std::any_of(stamps.begin(), stamps.end(), [](const auto& s) { return s && s->clock_us % kSecond_us != 0; });
  for (auto& s : stamps) {
    if (s && !has_fraction) s->resolution_us = std::max(s->resolution_us, kSecond_us);
  }
}

std::vector<TimeSource> sources_of(const std::vector<DatedPhoto>& photos) {
  TimeSource original{"EXIF DateTimeOriginal", "EXIF DateTimeOriginal", {}, &DatedPhoto::date_time},
      digitized{"EXIF DateTimeDigitized", "EXIF DateTimeDigitized", {}, &DatedPhoto::digitized};
  std::vector<std::string> names;
  for (const DatedPhoto& photo : photos) {
    original.stamps.push_back(time_in_exif(photo.date_time));
    digitized.stamps.push_back(time_in_exif(photo.digitized));
    names.push_back(photo.file.stem().string());
  }
  std::vector<TimeSource> sources{
      original, digitized, {"dates in file names", "date in the name", times_in_names(names), nullptr}};
  for (TimeSource& source : sources) {
    coarsen(source.stamps);
    source.problem = problem_with(source, photos);
  }
  return sources;
}

/// The worst of the photographs that are kept.
std::int64_t resolution_of(const TimeSource& source, const std::vector<DatedPhoto>& photos) {
  std::int64_t worst = 0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].is_kept && source.stamps[i]) worst = std::max(worst, source.stamps[i]->resolution_us);
  }
  return worst;
}

/// How two sources lie against one another: the shift of the second that explains most photographs, and those that it
/// does not explain.
struct Agreement {
  bool is_full = true;
  std::vector<std::size_t> outsiders = {};
};

/// A camera writes the file some time after the exposure.
constexpr std::int64_t kWritingDelay_us = 2 * kSecond_us;
/// UTC-12 to UTC+14 are 26 hours apart (docs/capture.md, Times).
constexpr std::int64_t kMaxZones_us = 26 * kHour_us;

/// @param lows,highs  Bounds of the shift by each photograph, in microseconds. @param most  Bound of the shift.
Agreement agreement_of(const std::vector<std::size_t>& photos, const std::vector<std::int64_t>& lows,
                       const std::vector<std::int64_t>& highs, std::int64_t most) {
  // The shift that most photographs allow lies at one of the lower bounds.
  std::vector<std::int64_t> begins = lows, ends = highs;
  std::sort(begins.begin(), begins.end());
  std::sort(ends.begin(), ends.end());
  std::ptrdiff_t most_allowed = 0;
  std::int64_t shift = 0;
  for (std::int64_t candidate : begins) {
    const std::ptrdiff_t num_begun = std::upper_bound(begins.begin(), begins.end(), candidate) - begins.begin();
    const std::ptrdiff_t num_ended = std::lower_bound(ends.begin(), ends.end(), candidate) - ends.begin();
    if (num_begun - num_ended > most_allowed) most_allowed = num_begun - num_ended, shift = candidate;
  }
  Agreement result;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (shift < lows[i] || shift > highs[i]) result.outsiders.push_back(photos[i]);
  }
  const std::int64_t highest = photos.empty() ? 0 : *std::min_element(highs.begin(), highs.end());
  result.is_full = result.outsiders.empty() && shift <= most && highest >= -most;
  return result;
}

/// @param is_utc  Where the first source says its offset from UTC, it is taken off.
Agreement compare_sources(const TimeSource& a, const TimeSource& b, bool is_utc) {
  std::vector<std::size_t> both;
  std::vector<std::int64_t> lows, highs;
  for (std::size_t i = 0; i < a.stamps.size(); ++i) {
    if (!a.stamps[i] || !b.stamps[i]) continue;
    const std::int64_t first = is_utc ? utc_us(*a.stamps[i]) : a.stamps[i]->clock_us;
    const std::int64_t second = is_utc ? utc_us(*b.stamps[i]) : b.stamps[i]->clock_us;
    both.push_back(i);
    lows.push_back(first - second - b.stamps[i]->resolution_us - kWritingDelay_us);
    highs.push_back(first - second + a.stamps[i]->resolution_us + kWritingDelay_us);
  }
  return agreement_of(both, lows, highs, kMaxZones_us);
}

/// "3 h", "72 h", "1.8 s".
std::string duration_text(std::int64_t duration_us) {
  const double seconds = static_cast<double>(duration_us) / kSecond_us;
  const double size = std::abs(seconds);
  const auto [unit, name] = size >= 3 * 86400.0  ? std::pair{86400.0, " d"}
                            : size >= 2 * 3600.0 ? std::pair{3600.0, " h"}
                            : size >= 120.0      ? std::pair{60.0, " min"}
                                                 : std::pair{1.0, " s"};
  return short_number_text(rounded(seconds / unit, 4)) + name;
}

/// "3 h after", "12 s before".
std::string later_text(std::int64_t duration_us) {
  return duration_text(std::abs(duration_us)) + (duration_us < 0 ? " before" : " after");
}

std::vector<std::string> names_of(const std::vector<std::size_t>& which, const std::vector<DatedPhoto>& photos) {
  std::vector<std::string> names;
  for (std::size_t i : which) names.push_back(file_name(photos[i]));
  return names;
}

/// Up to five of them.
std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, names.size()); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more" : text;
}

/// Both values of a photograph on which two sources differ.
HistoryWarning disagreement(const TimeSource& taken, const TimeSource& other, const std::vector<std::size_t>& outsiders,
                            const std::vector<DatedPhoto>& photos) {
  std::vector<std::size_t> both;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (taken.stamps[i] && other.stamps[i]) both.push_back(i);
  }
  const std::size_t shown = outsiders.empty() ? both.front() : outsiders.back();
  const auto reference = std::find_if(both.begin(), both.end(), [&](std::size_t i) {
    return std::find(outsiders.begin(), outsiders.end(), i) == outsiders.end();
  });
  HistoryWarning warning{
      .about = WarningSubject::Series, .text = "", .cure = "", .photos = names_of(outsiders, photos)};
  const auto value = [&](const TimeSource& source) {
    std::string text = stamp_text(*source.stamps[shown]) + " by " + source.name;
    if (reference != both.end() && *reference != shown) {
      text += " (" + later_text(source.stamps[shown]->clock_us - source.stamps[*reference]->clock_us) + " " +
              file_name(photos[*reference]) + ")";
    }
    return text;
  };
  const std::string count = outsiders.size() > 1
                                ? " (" + std::to_string(outsiders.size()) + " of " + std::to_string(both.size()) +
                                      " photographs: " + some_of(warning.photos) + ")"
                                : "";
  warning.text = "times disagree" + count + ": " + file_name(photos[shown]) + " is from " + value(taken) +
                 ", but from " + value(other) + "; " + taken.name + (taken.name.starts_with("dates") ? " are" : " is") +
                 " used";
  warning.cure = "give `interval`, or a list with times, if that is wrong";
  warning.share = 1.0;
  return warning;
}

/// Names that follow a clock which was changed are put on one scale by the offsets that EXIF knows.
void take_offsets(TimeSource& names, const TimeSource& exif) {
  for (std::size_t i = 0; i < names.stamps.size(); ++i) {
    if (names.stamps[i] && exif.stamps[i] && !names.stamps[i]->offset_min)
      names.stamps[i]->offset_min = exif.stamps[i]->offset_min;
  }
}

std::string span_text(const TimeSource& source, const std::vector<DatedPhoto>& photos) {
  const auto moments = moments_of(source.stamps, photos);
  std::optional<std::size_t> first, last;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].is_kept) continue;
    if (!first || *moments[i] < *moments[*first]) first = i;
    if (!last || *moments[i] > *moments[*last]) last = i;
  }
  const std::string begin = stamp_text(*source.stamps[*first]);
  return first == last ? begin : begin + " to " + stamp_text(*source.stamps[*last]);
}

std::vector<double> relative_times(const TimeSource& source, const std::vector<DatedPhoto>& photos, TimeUnit unit) {
  const auto moments = moments_of(source.stamps, photos);
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  for (const auto& moment : moments) {
    if (moment) first = std::min(first, *moment);
  }
  std::vector<double> times;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].is_kept) times.push_back(static_cast<double>(*moments[i] - first) / kSecond_us / seconds_per(unit));
  }
  return times;
}

}  // namespace

std::string photo_time_text(const std::filesystem::path& file, const ImageInfo& info) {
  for (const TimeSource& source : sources_of({{file, info.date_time, info.digitized}})) {
    if (!source.stamps.front()) continue;
    return stamp_text(*source.stamps.front()) + " (" + (source.name.starts_with("dates") ? "file name" : source.name) +
           ")";
  }
  return "";
}

FrameTimes find_frame_times(const std::vector<DatedPhoto>& photos, TimeUnit unit) {
  const bool has_photo = std::any_of(photos.begin(), photos.end(), [](const DatedPhoto& p) { return p.is_kept; });
  if (!has_photo) throw InvalidInput("frames: there is no photograph");
  std::vector<TimeSource> sources = sources_of(photos);
  const auto first =
      std::find_if(sources.begin(), sources.end(), [](const TimeSource& s) { return s.problem.empty(); });
  if (first == sources.end()) {
    std::string tried;
    for (const TimeSource& s : sources)
      tried += (tried.empty() ? "" : &s == &sources.back() ? " and " : ", ") + s.name + " (" + s.problem + ")";
    throw InvalidInput("frames: no times; tried " + tried + "; give `interval`, or a list with times");
  }
  TimeSource* taken = &*first;
  std::vector<std::pair<const TimeSource*, Agreement>> others;
  for (TimeSource& other : sources) {
    if (&other == &*first || !other.says_something()) continue;
    const Agreement by_clock = compare_sources(*first, other, false), by_utc = compare_sources(*first, other, true);
    const bool is_full = by_clock.is_full || by_utc.is_full;
    others.emplace_back(&other, by_clock.outsiders.size() <= by_utc.outsiders.size() ? by_clock : by_utc);
    others.back().second.is_full = is_full;
    const bool is_finer = resolution_of(other, photos) < resolution_of(*taken, photos);
    if (!is_full || !other.problem.empty() || !is_finer) continue;
    if (by_clock.is_full && !by_utc.is_full) take_offsets(other, *first);
    taken = &other;
  }
  FrameTimes result{relative_times(*taken, photos, unit), taken->name, span_text(*taken, photos), {}};
  for (const auto& [other, agreement] : others) {
    if (!agreement.is_full) result.warnings.push_back(disagreement(*first, *other, agreement.outsiders, photos));
  }
  return result;
}

std::vector<HistoryWarning> check_stated_times(const std::vector<DatedPhoto>& photos, const std::vector<double>& times,
                                               TimeUnit unit) {
  std::vector<HistoryWarning> warnings;
  if (photos.size() < 2) return warnings;
  constexpr double kMost_us = 1e18;  // Fits into 64 bits.
  const auto us_of = [&](double time) {
    return static_cast<std::int64_t>(
        std::llround(std::clamp(time * seconds_per(unit) * kSecond_us, -kMost_us, kMost_us)));
  };
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < times.size(); ++i) step = std::min(step, std::abs(times[i] - times[i - 1]));
  constexpr double kDrift = 0.02;  // Drift of a clock that is no disagreement, of the series' length.
  const std::int64_t tolerance = us_of(0.5 * step + kDrift * std::abs(times.back() - times.front()));
  for (const TimeSource& source : sources_of(photos)) {
    if (!source.problem.empty()) continue;
    const auto moments = moments_of(source.stamps, photos);
    std::vector<std::size_t> which(photos.size());
    std::iota(which.begin(), which.end(), std::size_t{0});
    std::vector<std::int64_t> lows, highs;
    for (std::size_t i : which) {
      lows.push_back(us_of(times[i]) - *moments[i] - source.stamps[i]->resolution_us - tolerance);
      highs.push_back(us_of(times[i]) - *moments[i] + tolerance);
    }
    const Agreement agreement = agreement_of(which, lows, highs, std::numeric_limits<std::int64_t>::max());
    if (agreement.is_full) continue;
    const std::size_t last = agreement.outsiders.back(), before = last == 0 ? photos.size() - 1 : 0;
    warnings.push_back(
        {.about = WarningSubject::Series,
         .text = "stated times disagree with " + source.name + ": " + file_name(photos[last]) + " is " +
                 later_text(us_of(times[last]) - us_of(times[before])) + " " + file_name(photos[before]) +
                 " as stated, " + later_text(*moments[last] - *moments[before]) + " it by " + source.name +
                 "; the stated times are used",
         .cure = "leave `interval` or the list's times out if they are wrong, or name the files in order",
         .share = 1.0,
         .photos = names_of(agreement.outsiders, photos)});
    break;  // One source is enough.
  }
  return warnings;
}

}  // namespace patinate::capture
