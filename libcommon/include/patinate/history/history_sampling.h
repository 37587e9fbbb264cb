/// \file
/// What a history shows between its frames.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/history/history_value.h"

namespace patinate {

/// Discrete treatments (cleaned, varnished) are not a smooth film: a blend of them shows a state that never was.
enum class Between {
  Blend,    ///< The two frames around, weighted by time.
  Hold,     ///< The last frame at or before.
  Nearest,  ///< The frame nearest in time; halfway the later one.
};

struct SamplingOptions {
  Between between = Between::Blend;  ///< What is shown between two frames.
};
void describe(OptionVisitor& v, SamplingOptions& o);

/// Where a time falls; the fraction is 0 but for Blend. @throws InvalidInput if `time` is NaN.
[[nodiscard]] TimePosition locate(const History& history, double time, Between between);
/// locate() for millions of times: equal to it to the bit, in about the time of two memory reads. Immutable.
class FrameLocator {
 public:
  /// @param times  Of the frames: at least one, strictly increasing.
  FrameLocator(std::vector<double> times, Between between);
  /// @param time  Not NaN (which gives the last frame). @param hint  A frame that it may lie after, as the one of a
  /// neighbor: any index.
  [[nodiscard]] TimePosition operator()(double time, int hint = 0) const {
    const double* const times = times_.data();
    const int last = static_cast<int>(times_.size()) - 1;
    int index = hint;
    if (!(hint < last && times[hint] <= time && time < times[hint + 1])) {
      if (time <= times[0]) return {0, 0.0};
      if (!(time < times[last])) return {last, 0.0};
      const auto bin = static_cast<std::size_t>((time - times[0]) * bins_per_time_);
      // Rounding may put a time into the bin beside its own.
      index = first_[bin < first_.size() ? bin : first_.size() - 1];
      while (times[index] > time) --index;
      while (times[index + 1] <= time) ++index;
    }
    const double fraction = (time - times[index]) / (times[index + 1] - times[index]);
    if (between_ == Between::Blend) return {index, fraction};
    return {between_ == Between::Nearest && fraction >= 0.5 ? index + 1 : index, 0.0};
  }

 private:
  Between between_;
  std::vector<double> times_;
  double bins_per_time_ = 0.0;
  std::vector<std::int32_t> first_;  ///< Per bin of equal length: the frame at or before its beginning.
};

/// H x W x 3, linear: the history at any time. Blend is History::sample(). @throws as it does.
[[nodiscard]] ImageF sample(const History& history, double time, Between between);

}  // namespace patinate
