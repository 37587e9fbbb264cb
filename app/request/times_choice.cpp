#include "app/request/times_choice.h"

#include <algorithm>
#include <cmath>

#include "app/request/usage_error.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"

namespace patinate::app {

namespace {

std::vector<double> evenly(const HistoryManifest& history, int count) {
  const double first = history.frames.front().time, last = history.frames.back().time;
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    times.push_back(count == 1 || i == count - 1 ? last : first + (last - first) * i / (count - 1));
  }
  return times;
}

}  // namespace

void TimesChoice::check() const {
  if ((time ? 1 : 0) + (times.empty() ? 0 : 1) + (count ? 1 : 0) > 1) {
    throw UsageError("--time, --times, --num-times: give one of them");
  }
  if (count && (!(*count >= 1 && *count <= 10000) || *count != std::floor(*count)))
    throw UsageError("--num-times: found `" + number_text(*count) + "`; expected an integer [1, 10000]");
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (std::find(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(i), times[i]) ==
        times.begin() + static_cast<std::ptrdiff_t>(i))
      continue;
    throw UsageError("--times: " + number_text(times[i]) + " is given twice");
  }
}

std::vector<double> TimesChoice::resolve(const HistoryManifest& history, int default_count,
                                         std::vector<std::string>& notes) const {
  check();
  if (count) return evenly(history, static_cast<int>(*count));
  std::vector<double> chosen = times;
  if (time) chosen = {*time};
  for (double t : chosen) {
    if (t >= history.frames.front().time && t <= history.frames.back().time) continue;
    notes.push_back("time " + number_text(t) + " is outside the history (" + number_text(history.frames.front().time) +
                    " to " + number_text(history.frames.back().time) + " " + shown_time_unit(history.time_unit) +
                    "): its end is used");
  }
  if (!chosen.empty()) return chosen;
  const bool has_span = history.frames.front().time < history.frames.back().time;
  if (default_count > 0) return evenly(history, has_span ? default_count : 1);  // One photograph is shown once.
  for (const HistoryFrame& frame : history.frames) chosen.push_back(frame.time);
  return chosen;
}

std::vector<std::string> time_labels(const std::vector<double>& times, TimeUnit unit) {
  std::vector<std::string> labels = short_number_texts(times);
  for (std::string& label : labels) label += " " + shown_time_unit(unit);
  return labels;
}

}  // namespace patinate::app
