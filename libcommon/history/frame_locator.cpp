#include "libcommon/history/frame_locator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace patinate {

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

}  // namespace patinate
