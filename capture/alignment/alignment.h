/// \file
/// Brings one photograph of a flat object into the view of another, though they look different: lit from the front
/// here, from behind there.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::capture {

enum class AlignmentStatus {
  Converged,
  TooFewDetails,  ///< An image shows too little to match.
  NoAgreement,    ///< Matches agree on no view of a plane.
  Doubtful,       ///< A view was found, but the images do not look alike in it.
};
[[nodiscard]] std::string alignment_status_text(AlignmentStatus status);

/// How pixels of one image lie in another.
struct ImageAlignment {
  AlignmentStatus status = AlignmentStatus::NoAgreement;
  Eigen::Matrix3d reference_from_image = Eigen::Matrix3d::Identity();  ///< Homography of pixel centers, lower right 1.
  int num_matches = 0;                                                 ///< Features that the images share.
  int num_inliers = 0;       ///< Patches (or point pairs) that agree on the view.
  double residual_px = 0.0;  ///< Root mean square of the inliers' distances in the reference.
  double correlation = 0.0;  ///< Mean over the inliers' patches, in [-1, 1].
};

/// Homography between two photographs of a plane, by what both show: edges and cracks, whether dark or bright.
///
/// Both become maps of local contrast without sign, |G_1 * log I - G_6 * log I| over its local strength; SIFT features
/// of these [Lowe 2004] that match both ways are reduced to a homography by RANSAC [Fischler and Bolles 1981]. Then
/// patches of 41 pixels find their own shifts by normalized cross-correlation, and the homography is fitted again,
/// robustly, four times. Images larger than 1600 pixels are matched at that size. Mirrored views are not found.
/// @param reference,image  H x W x 1, linear light, >= 0; sizes may differ; at least 32 pixels a side.
/// @returns A status other than Converged when the result should not be used.
/// @throws InvalidInput if an image is too small or no gray image.
[[nodiscard]] ImageAlignment align_images(const ImageF& reference, const ImageF& image, const RunControl& control = {});

/// A point in two images.
struct PointPair {
  Eigen::Vector2d in_image;
  Eigen::Vector2d in_reference;
};
/// Homography of least squares through four or more pairs; residual_px says how well they agree (0 for four).
/// @throws InvalidInput for fewer than four, or when they determine no homography (three on a line).
[[nodiscard]] ImageAlignment align_points(const std::vector<PointPair>& pairs);

/// An image seen in the reference, and where it reaches.
struct WarpedImage {
  ImageF values;     ///< height x width x C; 0 where the image does not reach.
  ImageU8 coverage;  ///< 255 where it does.
};
/// Cubic interpolation, after a Gaussian where the image is finer than the reference.
/// @throws InvalidInput unless the homography can be inverted.
[[nodiscard]] WarpedImage warp_image(const ImageF& image, const Eigen::Matrix3d& reference_from_image, int width,
                                     int height);

}  // namespace patinate::capture
