#include "libcommon/core/time_left.h"

#include <algorithm>

namespace patinate {

namespace {

constexpr double kMinSeconds = 2.0, kMinFraction = 0.02;
// Share of the time since the first report: long enough for a mean over stages whose weights are not exact, short
// enough to follow a change of speed.
constexpr double kWindow = 2.0 / 3.0;
constexpr double kMinWindow = 5.0;  // Seconds.
constexpr double kMinStep = 0.05;   // Seconds between reports that are kept.

}  // namespace

void TimeLeft::add(double seconds, double fraction) {
  if (!(fraction > 0.0)) return;
  if (!reports_.empty() && !(fraction > reports_.back().fraction)) return;
  const std::size_t size = reports_.size();
  if (size >= 2 && reports_[size - 1].seconds - reports_[size - 2].seconds < kMinStep) {
    reports_.back() = {seconds, fraction};
  } else {
    reports_.push_back({seconds, fraction});
  }
  begin_ = reports_.size() == 1 ? seconds : begin_;
  const double window = std::max(kMinWindow, kWindow * (seconds - begin_));
  while (reports_.size() > 2 && reports_[1].seconds <= seconds - window &&
         reports_.back().fraction - reports_[1].fraction >= kMinFraction)
    reports_.pop_front();
}

std::optional<double> TimeLeft::seconds() const {
  if (reports_.size() < 2) return std::nullopt;
  const double passed = reports_.back().seconds - reports_.front().seconds,
               done = reports_.back().fraction - reports_.front().fraction;
  if (!(passed >= kMinSeconds && done >= kMinFraction)) return std::nullopt;
  return passed / done * (1.0 - reports_.back().fraction);
}

}  // namespace patinate
