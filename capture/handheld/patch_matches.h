/// \file
/// How one photograph lies in another one, exactly, once it is known to a few pixels.
#pragma once

#include "capture/handheld/photo_pair.h"

namespace patinate::capture {

/// Pair from patches: the finer photograph is laid over the other one, and patches of 41 pixels, all over what both
/// show, find their own shifts of up to 6 px by normalized cross-correlation; then as judge_matches(). In pixels of the
/// reduced photographs (PhotoFeatures::evened).
/// @param b_from_a  What is known of it.
[[nodiscard]] PhotoPair align_patches(int a, const PhotoFeatures& of_a, int b, const PhotoFeatures& of_b,
                                      const Eigen::Matrix3d& b_from_a, AlignModel model);

}  // namespace patinate::capture
