#include "patinate/history/history_sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace patinate {

namespace {
constexpr std::array<std::string_view, 3> kBetweenNames{"blend", "hold", "nearest"};
}

void describe(OptionVisitor& v, SamplingOptions& o) {
  v.visit_choice({"between", "Between two frames: their blend, the one before, or the nearest"}, o.between,
                 kBetweenNames);
}

TimePosition locate(const History& history, double time, Between between) {
  const TimePosition position = history.locate(time);
  if (between == Between::Blend) return position;
  const bool is_later = between == Between::Nearest && position.fraction >= 0.5;
  return {is_later ? position.index + 1 : position.index, 0.0};
}

FrameLocator::FrameLocator(std::vector<double> times, Between between) : between_(between), times_(std::move(times)) {
  constexpr std::size_t kMostBins = 1 << 16;
  const std::size_t num_bins = std::min(kMostBins, 8 * times_.size());
  const double length = times_.back() - times_.front();
  bins_per_time_ = length > 0.0 ? static_cast<double>(num_bins) / length : 0.0;
  if (!std::isfinite(bins_per_time_)) bins_per_time_ = 0.0;  // A search from the first frame on.
  for (std::size_t bin = 0; bin < num_bins; ++bin) {
    const double begin = times_.front() + length * static_cast<double>(bin) / static_cast<double>(num_bins);
    const auto after = std::upper_bound(times_.begin() + 1, times_.end() - (times_.size() > 1 ? 1 : 0), begin);
    first_.push_back(static_cast<std::int32_t>(after - times_.begin()) - 1);
  }
}

ImageF sample(const History& history, double time, Between between) {
  if (between == Between::Blend) return history.sample(time);
  return history.read_frame(locate(history, time, between).index);
}

}  // namespace patinate
