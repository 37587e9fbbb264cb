/// \file
/// match_control() value by value, for who knows a value's rank among the destination's.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/transfer/control_matching.h"

namespace patinate::transfer {

/// What is known of all values of a destination.
struct ControlValues {
  std::int64_t count = 0;  ///< > 0
  float least = 0.0f, greatest = 0.0f;
};

/// As match_control() says.
class ControlMatcher {
 public:
  /// @throws InvalidInput as match_control().
  ControlMatcher(const ControlValues& destination, const ControlRange& destination_range, const ImageF& source,
                 const ImageU8& source_mask, const ControlRange& source_range, ControlMapping mapping,
                 const RunControl& control);

  [[nodiscard]] bool needs_ranks() const { return mapping_ == ControlMapping::Rank; }
  /// @param num_below,num_up_to  Of the destination's values, those < and <= this one; looked at where needs_ranks().
  [[nodiscard]] float operator()(float value, std::int64_t num_below, std::int64_t num_up_to) const;

 private:
  ControlValues from_;
  ControlRange from_range_, to_range_;
  ControlMapping mapping_;
  std::vector<float> to_;  ///< Sorted.
};

/// In order.
void sort_values(std::vector<float>& values, const RunControl& control);

}  // namespace patinate::transfer
