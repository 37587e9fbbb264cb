/// \file
/// A control parameter from the history itself, for captures where nothing was measured.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::capture {

struct ProgressOptions {
  /// Gaussian over the frames before they are compared, so that the map guides by region and not by grain; >= 0.
  /// Not given: 1 % of the shorter side, at least 1.5 px.
  std::optional<double> smoothing_px;
};
void describe(OptionVisitor& v, ProgressOptions& o);

/// Standard deviations of the frames' colors.
struct FrameDeviations {
  /// Deviation of frame i: H x W x 3, linear, >= 0. Empty: nothing is known.
  std::function<ImageF(int)> read = {};
  /// Neighboring pixels are off together (light, shape), so that smoothing does not help; if not, each is by itself.
  bool is_shared = false;
};

/// How early each pixel ages.
struct ProgressMap {
  ImageF values;     ///< H x W x 1 in [0, 1]: share of the recorded time that the pixel spent aged.
  double low = 0.0;  ///< Robust range (1 % and 99 %) over the pixels that change.
  double high = 0.0;
  double aged_change = 0.0;     ///< The change that counts as aged: distance of sRGB codes in [0, sqrt 3].
  double changing_share = 0.0;  ///< Share of the pixels (inside the mask) that change at all.
  ImageF deviation = {};  ///< Standard deviation of `values` (progress_deviation.h); empty without FrameDeviations.
};

/// progress(p) = time average of min(1, d(p, t) / D): 1 = aged from the start, 0 = never. Higher is earlier.
///
/// - d(p, t) is the distance, in sRGB-encoded RGB, between the frame at t and the first one, both blurred by
/// smoothing_px
///   (only with what lies inside the mask); inner frames are replaced by the median of three in time, channel by
///   channel, so that one spoilt photograph does not count.
/// - A pixel changes when max_t d exceeds 0.02 and a tenth of the 99th percentile of max_t d: backgrounds and
///   fixtures do not, and have no part in D, low and high.
/// - D, one for the whole map, is the 90th percentile of max_t d over the changing pixels: the change of a fully aged
///   pixel. (A scale per pixel would blow noise up where little happens; a smaller one saturates and shows no order.)
/// - The average is over time, not over frames: trapezoids between uneven times.
///
/// Reads every frame twice, at reduced resolution; holds three at a time. With deviations once more.
/// @param times       Strictly increasing; one or more. With one frame progress is 0 everywhere.
/// @param read_frame  Frame i as H x W x 3, linear, finite.
/// @param mask        H x W; may be empty.
/// @throws InvalidInput if an option is out of range, frames differ in size, or the mask covers nothing.
/// Same bits for any number of threads.
[[nodiscard]] ProgressMap progress_from_history(const std::vector<double>& times,
                                                const std::function<ImageF(int)>& read_frame, const ImageU8& mask,
                                                const ProgressOptions& options = {}, const RunControl& control = {},
                                                const FrameDeviations& deviations = {});

/// Progress of a history: its frames and its mask.
[[nodiscard]] ProgressMap progress_from_history(const History& history, const ProgressOptions& options = {},
                                                const RunControl& control = {});

}  // namespace patinate::capture
