/// \file
/// What an item of a factorization says of the frame of the denoised history that it has made.
#pragma once

#include <cstdint>
#include <optional>

#include "patinate/core/json.h"

namespace patinate::analysis {

/// How far a frame is from the history's own, over the pixels that both show.
struct FrameError {
  std::int64_t num_pixels = 0;  ///< At least 1.
  double rmse = 0.0;            ///< Linear, of all channels.
  double ciede2000_mean = 0.0;
  double ciede2000_p95 = 0.0;
  bool is_color = true;  ///< Else there are no differences of color.
};

struct FrameRecord {
  double time = 0.0;  ///< In the history's unit.
  std::optional<double>
      covered_share;     ///< Share of what changes that is covered, [0, 1]; given where the frame is extrapolated.
  bool is_held = false;  ///< Holds the last frame seen: the curve predicts nothing better.
  std::optional<FrameError> error;  ///< Nothing where no frame of the history shows a place that is known.
};

/// An element of `frames` in factorization.json.
[[nodiscard]] Json frame_json(const FrameRecord& frame);
/// The inverse of frame_json(); for files of our own only.
[[nodiscard]] FrameRecord frame_from_json(const Json& json);

}  // namespace patinate::analysis
