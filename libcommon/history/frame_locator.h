/// \file
/// Where millions of times fall between the frames of a history.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "libcommon/core/kernel_language.h"
#include "patinate/history/history_sampling.h"

namespace patinate {

/// frame_locator.inl for C++; devices read the same text.
namespace frame_kernel {
using namespace kernel_types;
#include "libcommon/history/frame_locator.inl"
}  // namespace frame_kernel
/// The text of frame_locator.inl.
extern const std::string_view kFrameKernel;

/// locate() for millions of times: equal to it to the bit, in about the time of two memory reads. Immutable.
class FrameLocator {
 public:
  /// @param times  Of the frames: at least one, strictly increasing.
  FrameLocator(std::vector<double> times, Between between);
  /// @param time  Not NaN (which gives the last frame). @param hint  A frame that it may lie after, as the one of a
  /// neighbor: any index.
  [[nodiscard]] TimePosition operator()(double time, int hint = 0) const {
    const frame_kernel::FrameTimes frames = tables();
    const frame_kernel::FramePosition at = frame_kernel::locate_frame(&frames, time, hint);
    return {at.index, at.fraction};
  }
  /// What locate_frame() reads; good as long as this.
  [[nodiscard]] frame_kernel::FrameTimes tables() const {
    return {.times = times_.data(),
            .first = first_.data(),
            .bins_per_time = bins_per_time_,
            .num_times = static_cast<std::int32_t>(times_.size()),
            .num_bins = static_cast<std::int32_t>(first_.size()),
            .between = static_cast<std::int32_t>(between_)};
  }

 private:
  Between between_;
  std::vector<double> times_;
  double bins_per_time_ = 0.0;
  std::vector<std::int32_t> first_;  ///< Per bin of equal length: the frame at or before its beginning.
};

}  // namespace patinate
