/// \file
/// Pixels that are not known in every frame: filled from the frames before and after, or excluded from the history.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Content of a pixel of a frame, as a code of an 8-bit image.
enum class Validity : std::uint8_t {
  OutOfView = 0,   ///< The camera did not see it.
  Highlight = 64,  ///< A highlight that stands still.
  Saturated = 128,
  Valid = 255,
};

struct FillOptions {
  double longest_gap =
      0.1;  ///< [0, 1]. Share of the recorded time over which color is interpolated; one missing frame always is.
};
void describe(OptionVisitor& v, FillOptions& o);

/// Pixels that stay, and frames that need filling.
struct FillPlan {
  ImageU8 inside;  ///< 255 where the color is known, or can be filled, in every frame.
  Image<std::int32_t>
      white_from;  ///< Frame from which on a pixel is saturated to the end: it grew white; num_frames if never.
  std::vector<char> needs_fill;  ///< Per frame: some inside pixel must be filled.
  double invalid_share = 0.0;    ///< Invalid share of all pixels of all frames.
};

/// Goes through the frames once, in order; memory does not depend on their number.
///
/// A pixel that is invalid between two valid frames a < b is filled when b = a + 2 or t_b - t_a <= longest_gap of the
/// recorded time. One that is invalid from the start, to the end, or for longer is outside; but one that is saturated
/// from some frame to the end, with valid ones before, grew white (a crystal) and stays as it is.
/// @param read_validity  Frame i: H x W codes of Validity. @throws InvalidInput if an option is out of range or sizes
/// differ.
[[nodiscard]] FillPlan plan_fill(const std::vector<double>& times, const std::function<ImageU8(int)>& read_validity,
                                 const FillOptions& options = {}, const RunControl& control = {});

/// Frame `index` with its invalid inside pixels interpolated linearly in time between the nearest valid frames.
/// @param read_frame  Frame i, H x W x 3; only valid pixels of it are used.
[[nodiscard]] ImageF fill_frame(int index, const std::vector<double>& times, const FillPlan& plan,
                                const std::function<ImageU8(int)>& read_validity,
                                const std::function<ImageF(int)>& read_frame);

/// The mask of a frame: 0 where it does not show the surface, though it may be filled; 255 where it does.
[[nodiscard]] ImageU8 frame_mask(int index, const ImageU8& validity, const FillPlan& plan);

}  // namespace patinate::capture
