/// \file
/// Bringing moved photographs back: one motion per frame from many pairs, and one resampling.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "capture/stability/survey.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// Where the first frame's picture lies in every frame.
struct StabilizedMotions {
  std::vector<Eigen::Affine2d> frame_from_first;  ///< x_in_frame = frame_from_first * x_in_first, photograph's pixels.
  std::vector<int> unlinked_frames;  ///< No chain of reliable pairs ties them to the largest group of frames; where no
                                     ///< other pair says how they lie, they are taken as not moved. Rising;
                                     ///< all frames when no two are tied.
  double residual_px = 0.0;          ///< Root mean square disagreement of the pairs at the corners, weighted.
  std::vector<double> frame_residual_px;  ///< Residual of each frame's own pairs; 0 without any.
};

/// All frames' motions at once: weighted least squares over the pairs, linear in where three corners of the first frame
/// lie in each frame, with Cauchy weights against wrong pairs. Pairs of neighbors alone would let errors add up along
/// the chain; pairs with anchor frames hold it.
/// @param pairs  Any; every frame but the first should be the `frame` of at least one. Unreliable ones are excluded.
/// @param width,height  Of the photographs. @throws InvalidInput if a pair names a frame outside [0, num_frames).
[[nodiscard]] StabilizedMotions solve_motions(int num_frames, const std::vector<FramePair>& pairs, int width,
                                              int height);

/// Samples an image once: out(x, y) = image at source_from_out * (x, y), by Catmull-Rom cubics kept within the range of
/// the 2 x 2 nearest pixels' neighborhood, so that edges do not ring.
/// @param valid  Becomes width x height: 0 where the position lies outside the image (the nearest pixel's value is
/// stored), else 255.
/// @param width,height  >= 1. An identity with whole-number offsets copies values exactly.
[[nodiscard]] ImageF resample_frame(const ImageF& image, const Eigen::Affine2d& source_from_out, int width, int height,
                                    ImageU8& valid, const RunControl& control = {});

}  // namespace patinate::capture
