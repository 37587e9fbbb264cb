/// \file
/// Where millions of times fall between the frames of a history.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/history/history_sampling.h"

namespace patinate {

/// locate() for millions of times: equal to it to the bit, in about the time of two memory reads. Immutable.
class FrameLocator {
 public:
  /// @param times  Of the frames: at least one, strictly increasing.
  FrameLocator(std::vector<double> times, Between between);
  /// @param time  Not NaN (which gives the last frame). @param hint  A frame that it may lie after, as the one of a
  /// neighbor: any index.
  [[nodiscard]] TimePosition operator()(double time, int hint = 0) const {
    const std::vector<double>& times = times_;
    const auto at = [&](int frame) { return times[frame]; };
    const int last = static_cast<int>(times.size()) - 1;
    int index = hint;
    if (!(hint < last && at(hint) <= time && time < at(hint + 1))) {
      index = time <= times.front() ? 0 : last;
      if (time <= times.front() || !(time < times.back())) return {index, 0.0};
      const auto bin = static_cast<std::size_t>((time - times.front()) * bins_per_time_);
      index =
          first_[bin < first_.size() ? bin : first_.size() - 1];  // Rounding may put it into the bin beside its own.
      while (at(index) > time) --index;
      while (at(index + 1) <= time) ++index;
    }
    const double fraction = (time - at(index)) / (at(index + 1) - at(index));
    if (between_ == Between::Nearest && fraction >= 0.5) ++index;
    return {index, between_ == Between::Blend ? fraction : 0.0};
  }

 private:
  Between between_;
  std::vector<double> times_;
  double bins_per_time_ = 0.0;
  std::vector<std::int32_t> first_;  ///< Per bin of equal length: the frame at or before its beginning.
};

}  // namespace patinate
