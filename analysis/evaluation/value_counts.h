/// \file
/// How often values occur, in bins of equal width: counts of parts add up to those of the whole, in any order.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace patinate::analysis {

/// Values >= 0 to the nearest multiple of `width`.
class ValueCounts {
 public:
  ValueCounts() = default;
  /// @param width  > 0.
  explicit ValueCounts(double width) : width_(width) {}

  void add(double value) {
    const double at = std::floor(value / width_ + 0.5);
    const std::size_t bin = at < kMostBins ? static_cast<std::size_t>(at) : kMostBins;
    if (bin >= counts_.size()) counts_.resize(bin + 1);
    ++counts_[bin];
    ++total_;
  }
  void add(const ValueCounts& other) {
    if (other.counts_.size() > counts_.size()) counts_.resize(other.counts_.size());
    for (std::size_t i = 0; i < other.counts_.size(); ++i) counts_[i] += other.counts_[i];
    total_ += other.total_;
    width_ = other.width_;
  }
  [[nodiscard]] std::int64_t total() const { return total_; }
  /// Values at ranks of the ascending list, which must ascend and be less than total().
  [[nodiscard]] std::vector<double> at_ranks(const std::vector<std::int64_t>& ranks) const {
    std::vector<double> values;
    std::int64_t passed = 0;
    std::size_t bin = 0;
    for (const std::int64_t rank : ranks) {
      while (passed + counts_[bin] <= rank) passed += counts_[bin++];
      values.push_back(static_cast<double>(bin) * width_);
    }
    return values;
  }
  [[nodiscard]] double at_rank(std::int64_t rank) const { return at_ranks({rank}).front(); }

 private:
  static constexpr std::size_t kMostBins = std::size_t{1} << 23;  ///< Larger values count as the largest.
  double width_ = 1.0;
  std::int64_t total_ = 0;
  std::vector<std::int64_t> counts_;
};

}  // namespace patinate::analysis
