/// \file
/// What a history shows between its frames.
#pragma once

#include "libcommon/core/options.h"
#include "libcommon/history/history.h"

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
[[nodiscard]] TimePosition locate(const HistoryReader& history, double time, Between between);
/// H x W x 3, linear: the history at any time. Blend is HistoryReader::sample(). @throws as it does.
[[nodiscard]] ImageF sample(const HistoryReader& history, double time, Between between);

}  // namespace patinate
