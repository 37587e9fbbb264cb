/// \file
/// How certain a progress map is, from what is known of its frames.
#pragma once

#include <functional>
#include <vector>

#include "patinate/image/image.h"

namespace patinate::capture {

/// Sums up, frame by frame, what the deviations of frames do to progress(p) = sum of w_i min(1, |v_i - v_0| / D), to
/// first order: var = sum_i (w_i s_i)^2 / D^2 along v_i - v_0, and what the first frame, which all are compared with,
/// does to all of them at once. To that comes, squared, by how much noise lengthens distances: without any change they
/// are not 0, and that does not average out. Where |v_i - v_0| is beyond D nothing moves. Deviations of different
/// frames are independent; D is taken as known.
class ProgressDeviation {
 public:
  /// @param first,first_variance  The first frame and its variance, H x W x 3, in sRGB codes of [0, 1].
  /// @param aged_change           D; > 0.
  ProgressDeviation(ImageF first, ImageF first_variance, double aged_change);

  /// @param weight  w_i. @param frame,variance  As the first one's.
  void add(double weight, const ImageF& frame, const ImageF& variance);
  /// H x W x 1.
  [[nodiscard]] ImageF result() const;

 private:
  ImageF first_, first_variance_;
  double aged_change_;
  ImageF own_;         ///< Variance from the frames themselves, of one channel.
  ImageF lengthened_;  ///< Sum of the weighted lengths that are noise.
  ImageF shared_;      ///< Sum of the weighted directions, which the first frame's deviation goes along with.
};

}  // namespace patinate::capture
