/// \file
/// How one photograph of a series lies in another one: a similarity, or a homography where the view was tilted.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "capture/handheld/photo_features.h"

namespace patinate::capture {

/// Differences between two photographs besides the surface.
enum class AlignModel {
  Auto,        ///< The simplest that the matches do not refute.
  Similarity,  ///< Shift, turn and scale.
  Homography,  ///< Any view of a plane.
};

/// A point of the object in two photographs, in their pixels.
struct PointMatch {
  Eigen::Vector2d in_a, in_b;
};

struct PhotoPair {
  int a = 0, b = 0;          ///< Photographs, by their place in the series.
  bool is_accepted = false;  ///< Enough matches agree on one view for chance to be excluded.
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();  ///< Pixel centers; lower right 1.
  bool is_marked = false;                                  ///< By a person's marks.
  bool refutes_similarity = false;                         ///< The matches show a tilted view.
  int num_matches = 0;                                     ///< Details that both show.
  int num_agreeing = 0;
  double error_px = 1.0;                 ///< Standard deviation of one match in b, in b's pixels; > 0.
  std::vector<PointMatch> matches = {};  ///< That agree, thinned to kMaxKept spread over the picture.
};
inline constexpr std::size_t kMaxKept = 80;

/// How far right matches lie from where they belong, and where wrong ones may lie.
struct MatchNoise {
  double inlier_px = 4.0;  ///< In b's pixels.
  double area_px2 = 1.0;   ///< Area of b, where a wrong match may lie.
};

/// Sets all of a pair but its photographs from matches some of which may be wrong: the view on which most agree, a
/// similarity by RANSAC [Fischler and Bolles 1981] or a homography by MAGSAC [Barath et al. 2019].
///
/// Accepted when fewer than 1e-6 such views are to be expected among matches that lie anywhere [Moisan and Stival
/// 2004], at least ten places agree that are more than 3 px apart, and they spread over a twentieth of the smaller
/// photograph. A similarity is refuted when a homography predicts the matches better by more than its four further
/// numbers can by chance, and moves one of them by more than a pixel; or when many more matches agree with it.
void judge_matches(const std::vector<PointMatch>& matches, const PhotoFeatures& of_a, const PhotoFeatures& of_b,
                   AlignModel model, const MatchNoise& noise, PhotoPair& pair);

/// Pair from features: mutual matches, judged.
[[nodiscard]] PhotoPair align_features(int a, const PhotoFeatures& of_a, int b, const PhotoFeatures& of_b,
                                       AlignModel model);

/// Pair from points that a person marked: all of them count. Not accepted with fewer than two (four for a homography)
/// or when they determine no view.
/// @param error_px  What a mark may be wrong by.
[[nodiscard]] PhotoPair align_marks(int a, int b, const std::vector<PointMatch>& marks, AlignModel model,
                                    double error_px);

/// Root mean square error, in b's pixels, of where an accepted pair's view brings the corners of photograph a, as far
/// as its matches' own errors make it: marks that are close together carry far points over badly.
[[nodiscard]] double carried_error_px(const PhotoPair& pair, double width, double height);

/// Least squares through two or more matches; not finite when they do not determine it.
[[nodiscard]] Eigen::Matrix3d fit_similarity(const std::vector<PointMatch>& matches);
/// Likewise through four or more.
[[nodiscard]] Eigen::Matrix3d fit_homography(const std::vector<PointMatch>& matches);
/// Where a homography moves a point.
[[nodiscard]] inline Eigen::Vector2d moved_by(const Eigen::Matrix3d& h, const Eigen::Vector2d& p) {
  return (h * p.homogeneous()).hnormalized();
}

}  // namespace patinate::capture
