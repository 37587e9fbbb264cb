/// \file
/// Which photographs are to blame when two that follow one another do not fit: those whose removal mends the series.
#pragma once

#include <functional>
#include <vector>

#include "capture/stability/survey.h"

namespace patinate::capture {

/// Photographs that follow one another.
struct FrameRun {
  int first = 0, last = 0;
  [[nodiscard]] int size() const { return last - first + 1; }
  bool operator==(const FrameRun&) const = default;
};

/// Runs of one to three frames, fewer than there are others, that neither fit what comes before nor what comes
/// after, so that the pair across them, (first - 1, last + 1), is worth measuring: find_odd_frames() and group_frames()
/// use it. Of runs longer than one the first 64: a series without any order is not worth more.
/// @param neighbors  As of judge_frames(), with its findings. By length, then rising; never with the first or last
/// frame.
[[nodiscard]] std::vector<FrameRun> runs_to_skip(const std::vector<FramePair>& neighbors,
                                                 const std::vector<FrameFinding>& findings);

/// Decides for every finding which of its two photographs stands out, and turns it round where that is the earlier one.
/// Judges motion, light and surface of a finding by themselves: it may fall into two.
///
/// - A run inside the series, of one to three frames and fewer than there are others, is odd when the pairs at both of
///   its ends are found wanting and its neighbors follow one another without it: motions or gains from end to end
///   cancel to less than half, or the pair across it fits better than either. The shortest run is blamed; each of its
///   frames is named. Of light one end that is found wanting is enough, where the other cancels it: aging may hide it.
/// - The first frame is odd when only its pair with the second is found wanting, not the next one.
/// - Otherwise it is the later one: the series goes on from there in another way.
/// @param across  Pairs (first - 1, last + 1) of runs_to_skip(); may be empty.
void find_odd_frames(std::vector<FrameFinding>& findings, const std::vector<FramePair>& neighbors,
                     const std::vector<FramePair>& across, int width, int height);

/// Frames that hang together, directly or over others, by pairs that `is_linked`. @returns Per frame the number of its
/// group, 0 for the largest one (of equal ones that with the earliest frame), then by size.
[[nodiscard]] std::vector<int> group_frames(int num_frames, const std::vector<FramePair>& pairs,
                                            const std::function<bool(const FramePair&)>& is_linked);
/// Frames that are not in the largest group, rising; all of them when no two hang together, none of a single one.
[[nodiscard]] std::vector<int> frames_outside(const std::vector<int>& groups);

}  // namespace patinate::capture
