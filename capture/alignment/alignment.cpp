#include "capture/alignment/alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "capture/alignment/clear_matches.h"
#include "capture/alignment/score_peak.h"
#include "libcommon/image/filters.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

constexpr int kMinSide = 32;  ///< px; a patch of 41 px and its search need about this.
/// px; larger photographs are matched at this size (docs/algorithms/alignment.md).
constexpr int kMatchedSide = 1600;
constexpr int kMaxFeatures = 6000;          ///< Strongest SIFT features of a photograph.
constexpr float kRatio = 0.85f;             ///< Lowe's test: nearest over second nearest descriptor.
constexpr double kInlierDistance_px = 3.0;  ///< RANSAC's distance (docs/algorithms/alignment.md).
constexpr int kMinInliers = 15;             ///< Matches that must agree (docs/algorithms/alignment.md).
constexpr int kPatch = 20;                  ///< Half side of the patches that make the view exact, in pixels.
constexpr int kPatchStep = 16;              ///< px between patches of a refinement round.
constexpr int kSearch = 5;                  ///< px that a patch is searched in each direction.
constexpr double kPatchDistance_px = 1.5;   ///< Patches within it are fitted (docs/algorithms/alignment.md).
constexpr double kMinCorrelation = 0.4;     ///< Share of a patch.
constexpr double kMinBend = 0.01;           ///< Bend of the correlation's peak, per square pixel.

cv::Mat as_mat(const ImageF& image) {
  return {image.height(), image.width(), CV_32FC(image.channels()), const_cast<float*>(image.data())};
}

/// Contrast without sign: cracks are bright whether they let light pass or swallow it. Mean near 0.5, in [0, 1].
cv::Mat contrast_map(const cv::Mat& light) {
  cv::Mat logarithm, fine, coarse, contrast, strength;
  const double level = cv::mean(light)[0];
  cv::log(cv::max(light, 0.01 * level + 1e-6), logarithm);
  cv::GaussianBlur(logarithm, fine, {}, 1.0);
  cv::GaussianBlur(logarithm, coarse, {}, 6.0);
  contrast = cv::abs(fine - coarse);
  cv::GaussianBlur(contrast, strength, {}, 24.0);
  cv::divide(contrast, 4.0 * strength + 1e-3, contrast);
  return cv::min(contrast, 1.0);
}

/// A matrix that scales pixels whose corners coincide: x' + 0.5 = s (x + 0.5).
cv::Matx33d pixel_scale(double sx, double sy) { return {sx, 0, 0.5 * sx - 0.5, 0, sy, 0.5 * sy - 0.5, 0, 0, 1}; }

struct MatchedImage {
  cv::Mat map;
  cv::Matx33d from_full;
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
};

MatchedImage prepare(const ImageF& image) {
  MatchedImage result;
  const cv::Mat full = as_mat(image);
  const double scale = std::min(1.0, static_cast<double>(kMatchedSide) / std::max(full.cols, full.rows));
  const cv::Size size(std::max(1, cvRound(full.cols * scale)), std::max(1, cvRound(full.rows * scale)));
  cv::Mat small = full;
  if (scale < 1.0) cv::resize(full, small, size, 0, 0, cv::INTER_AREA);
  result.from_full =
      pixel_scale(static_cast<double>(size.width) / full.cols, static_cast<double>(size.height) / full.rows);
  result.map = contrast_map(small);
  cv::Mat codes;
  result.map.convertTo(codes, CV_8U, 255.0);
  cv::SIFT::create(kMaxFeatures, 3, 0.02)->detectAndCompute(codes, {}, result.points, result.descriptors);
  return result;
}

struct Matches {
  std::vector<cv::Point2f> in_image;
  std::vector<cv::Point2f> in_reference;
};

Matches match(const MatchedImage& reference, const MatchedImage& image) {
  Matches matches;
  const std::vector<int> forth = clear_matches(image.descriptors, reference.descriptors, kRatio);
  const std::vector<int> back = clear_matches(reference.descriptors, image.descriptors, kRatio);
  for (std::size_t i = 0; i < forth.size(); ++i) {
    if (forth[i] < 0 || back[forth[i]] != static_cast<int>(i)) continue;
    matches.in_image.push_back(image.points[i].pt);
    matches.in_reference.push_back(reference.points[forth[i]].pt);
  }
  return matches;
}

/// Corners of an image as a homography shows them.
std::vector<cv::Point2d> corners_in(const cv::Matx33d& h, int width, int height) {
  const std::vector<cv::Point2d> corners{{0, 0}, {width - 1.0, 0}, {width - 1.0, height - 1.0}, {0, height - 1.0}};
  std::vector<cv::Point2d> moved;
  cv::perspectiveTransform(corners, moved, h);
  return moved;
}

/// Whether the whole image lies before the camera, is not mirrored, and is neither tiny nor huge in the reference.
bool is_plausible(const cv::Matx33d& h, const cv::Mat& image, const cv::Mat& reference) {
  for (const double x : {0.0, image.cols - 1.0}) {
    for (const double y : {0.0, image.rows - 1.0}) {
      if (!(h(2, 0) * x + h(2, 1) * y + h(2, 2) > 0.0)) return false;
    }
  }
  const std::vector<cv::Point2d> quad = corners_in(h, image.cols, image.rows);
  double twice_area = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2d a = quad[(i + 1) % 4] - quad[i], b = quad[(i + 2) % 4] - quad[(i + 1) % 4];
    if (!(a.cross(b) > 0.0)) return false;
    twice_area += quad[i].cross(quad[(i + 1) % 4]);
  }
  const double share = 0.5 * twice_area / (static_cast<double>(reference.cols) * reference.rows);
  return share > 0.04 && share < 25.0;
}

struct Displacement {
  cv::Point2f shift;
  double correlation = 0.0;
};

/// Where a patch of the reference lies in the warped image, to a fraction of a pixel; nothing when the correlation has
/// no clear peak in every direction (along a lone crack it has none).
std::optional<Displacement> find_patch(const cv::Mat& reference, const cv::Mat& warped, const cv::Point& center) {
  const cv::Rect patch(center.x - kPatch, center.y - kPatch, 2 * kPatch + 1, 2 * kPatch + 1);
  const cv::Rect area(patch.x - kSearch, patch.y - kSearch, patch.width + 2 * kSearch, patch.height + 2 * kSearch);
  cv::Mat scores;
  cv::matchTemplate(warped(area), reference(patch), scores, cv::TM_CCOEFF_NORMED);
  const std::optional<ScorePeak> peak = find_score_peak(scores, kMinCorrelation, kMinBend);
  if (!peak) return std::nullopt;
  return Displacement{{static_cast<float>(peak->pixel.x() - kSearch + peak->fraction.x()),
                       static_cast<float>(peak->pixel.y() - kSearch + peak->fraction.y())},
                      peak->score};
}

/// Matches of patches all over the reference in a view that is right to a few pixels.
struct PatchMatches {
  Matches matches;
  std::vector<double> correlations;
};

PatchMatches match_patches(const cv::Mat& reference, const cv::Mat& image, const cv::Matx33d& h) {
  cv::Mat warped, reached;
  cv::warpPerspective(image, warped, h, reference.size(), cv::INTER_LINEAR);
  cv::warpPerspective(cv::Mat(image.size(), CV_8U, cv::Scalar(255)), reached, h, reference.size(), cv::INTER_NEAREST);
  const cv::Matx33d inverse = h.inv();
  PatchMatches result;
  constexpr int kMargin = kPatch + kSearch;
  for (int y = kMargin; y < reference.rows - kMargin; y += kPatchStep) {
    for (int x = kMargin; x < reference.cols - kMargin; x += kPatchStep) {
      const cv::Rect area(x - kMargin, y - kMargin, 2 * kMargin + 1, 2 * kMargin + 1);
      if (cv::countNonZero(reached(area)) != area.area()) continue;
      const auto found = find_patch(reference, warped, {x, y});
      if (!found) continue;
      const cv::Point2f center(static_cast<float>(x), static_cast<float>(y));
      std::vector<cv::Point2f> in_image;
      cv::perspectiveTransform(std::vector<cv::Point2f>{center + found->shift}, in_image, inverse);
      result.matches.in_reference.push_back(center);
      result.matches.in_image.push_back(in_image.front());
      result.correlations.push_back(found->correlation);
    }
  }
  return result;
}

Eigen::Matrix3d normalized(const cv::Matx33d& h) {
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m(r, c) = h(r, c) / h(2, 2);
  }
  return m;
}

double rms_distance(const cv::Matx33d& h, const Matches& matches, const std::vector<unsigned char>& is_used) {
  std::vector<cv::Point2f> moved;
  cv::perspectiveTransform(matches.in_image, moved, h);
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (is_used[i] == 0) continue;
    const cv::Point2f d = moved[i] - matches.in_reference[i];
    sum += static_cast<double>(d.dot(d));
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

/// Makes the view exact by patches, each of which finds its own shift: what only one image shows (a frame, a border)
/// disturbs those that hold it and no others. Fills everything but num_matches. @returns false when too few patches
/// agree.
bool refine(const cv::Mat& reference, const cv::Mat& image, cv::Matx33d& h, ImageAlignment& result) {
  constexpr int kRounds = 4;  // Refinement rounds (docs/algorithms/alignment.md).
  for (int round = 0; round < kRounds; ++round) {
    const PatchMatches patches = match_patches(reference, image, h);
    if (patches.correlations.size() < static_cast<std::size_t>(kMinInliers)) return false;
    std::vector<unsigned char> is_inlier;
    const cv::Mat found = cv::findHomography(patches.matches.in_image, patches.matches.in_reference, cv::RANSAC,
                                             kPatchDistance_px, is_inlier, 5000, 0.9999);
    result.num_inliers = static_cast<int>(std::count(is_inlier.begin(), is_inlier.end(), 1));
    if (found.empty() || result.num_inliers < kMinInliers) return false;
    h = cv::Matx33d(found.ptr<double>());
    if (!is_plausible(h, image, reference)) return false;
    result.residual_px = rms_distance(h, patches.matches, is_inlier);
    double sum = 0.0;
    for (std::size_t i = 0; i < is_inlier.size(); ++i) sum += is_inlier[i] != 0 ? patches.correlations[i] : 0.0;
    result.correlation = sum / result.num_inliers;
  }
  return true;
}

void check_image(const ImageF& image) {
  if (image.channels() != 1 || std::min(image.width(), image.height()) < kMinSide) {
    throw InvalidInput("alignment: an image must be gray and have at least " + std::to_string(kMinSide) +
                       " pixels a side");
  }
}

}  // namespace

std::string alignment_status_text(AlignmentStatus status) {
  switch (status) {
    case AlignmentStatus::Converged:
      return "converged";
    case AlignmentStatus::TooFewDetails:
      return "too few details to match";
    case AlignmentStatus::NoAgreement:
      return "no view in which enough details agree";
    case AlignmentStatus::Doubtful:
      break;
  }
  return "a view was found in which the images do not look alike";
}

ImageAlignment align_images(const ImageF& reference, const ImageF& image, const RunControl& control) {
  check_image(reference);
  check_image(image);
  ImageAlignment result;
  const MatchedImage to = prepare(reference);
  control.throw_if_stopped();
  const MatchedImage from = prepare(image);
  control.throw_if_stopped();
  control.report(0.4);
  result.status = AlignmentStatus::TooFewDetails;
  if (std::min(to.points.size(), from.points.size()) < static_cast<std::size_t>(kMinInliers)) return result;
  const Matches matches = match(to, from);
  result.num_matches = static_cast<int>(matches.in_image.size());
  if (result.num_matches < kMinInliers) return result;
  control.throw_if_stopped();
  control.report(0.6);

  result.status = AlignmentStatus::NoAgreement;
  std::vector<unsigned char> is_inlier;
  const cv::Mat found = cv::findHomography(matches.in_image, matches.in_reference, cv::RANSAC, kInlierDistance_px,
                                           is_inlier, 5000, 0.9999);
  result.num_inliers = static_cast<int>(std::count(is_inlier.begin(), is_inlier.end(), 1));
  if (found.empty() || result.num_inliers < kMinInliers) return result;
  cv::Matx33d h(found.ptr<double>());
  if (!is_plausible(h, from.map, to.map)) return result;

  result.status = AlignmentStatus::Doubtful;
  if (!refine(to.map, from.map, h, result)) return result;
  result.residual_px /= to.from_full(0, 0);
  result.reference_from_image = normalized(to.from_full.inv() * h * from.from_full);
  result.status = AlignmentStatus::Converged;
  control.report(1.0);
  return result;
}

ImageAlignment align_points(const std::vector<PointPair>& pairs) {
  if (pairs.size() < 4) throw InvalidInput("alignment: four point pairs are needed");
  Matches matches;
  for (const PointPair& p : pairs) {
    matches.in_image.emplace_back(static_cast<float>(p.in_image.x()), static_cast<float>(p.in_image.y()));
    matches.in_reference.emplace_back(static_cast<float>(p.in_reference.x()), static_cast<float>(p.in_reference.y()));
  }
  const cv::Mat found = cv::findHomography(matches.in_image, matches.in_reference);
  const bool is_usable = !found.empty() && cv::checkRange(found) && std::abs(cv::determinant(found)) > 1e-9;
  const cv::Matx33d h = is_usable ? cv::Matx33d(found.ptr<double>()) : cv::Matx33d::eye();
  ImageAlignment result;
  const std::vector<unsigned char> all(pairs.size(), 1);
  result.residual_px = is_usable ? rms_distance(h, matches, all) : std::numeric_limits<double>::infinity();
  if (!is_usable || (pairs.size() == 4 && !(result.residual_px < 0.1))) {
    throw InvalidInput("alignment: the point pairs determine no view; no three of them may lie on a line");
  }
  result.status = AlignmentStatus::Converged;
  result.reference_from_image = normalized(h);
  result.num_matches = result.num_inliers = static_cast<int>(pairs.size());
  result.correlation = 1.0;
  return result;
}

WarpedImage warp_image(const ImageF& image, const Eigen::Matrix3d& reference_from_image, int width, int height) {
  const double determinant = reference_from_image.determinant();
  if (!(std::abs(determinant) > 1e-12) || !std::isfinite(determinant)) {
    throw InvalidInput("alignment: the homography cannot be inverted");
  }
  cv::Matx33d h;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) h(r, c) = reference_from_image(r, c);
  }
  // Pixels of the image per pixel of the reference, in its middle.
  const Eigen::Vector3d middle = reference_from_image * Eigen::Vector3d(0.5 * image.width(), 0.5 * image.height(), 1.0);
  const double fineness = std::sqrt(std::abs(middle.z() * middle.z() * middle.z() / determinant));
  const ImageF source = fineness > 1.2 ? gaussian_blur(image, 0.5 * std::sqrt(fineness * fineness - 1.0)) : image;
  WarpedImage warped{ImageF(width, height, image.channels()), ImageU8(width, height)};
  cv::Mat values = as_mat(warped.values);
  cv::warpPerspective(as_mat(source), values, h, values.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d p = reference_from_image.inverse() * Eigen::Vector3d(x, y, 1.0);
      const Eigen::Vector2d at = p.head<2>() / p.z();
      const bool is_inside = p.z() * determinant > 0.0 && at.x() >= -0.5 && at.y() >= -0.5 &&
                             at.x() <= image.width() - 0.5 && at.y() <= image.height() - 0.5;
      warped.coverage.at(x, y) = is_inside ? 255 : 0;
      for (float& v : warped.values.pixel(x, y)) v = is_inside && std::isfinite(v) ? std::max(0.0f, v) : 0.0f;
    }
  }
  return warped;
}

}  // namespace patinate::capture
