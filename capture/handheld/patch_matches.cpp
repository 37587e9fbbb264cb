#include "capture/handheld/patch_matches.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "capture/alignment/score_peak.h"
#include "capture/handheld/lay_photo.h"

namespace patinate::capture {

namespace {

constexpr int kPatch = 20;  ///< Half side.
constexpr int kSearch = 6;
constexpr int kLeastStep = 12;
constexpr int kMostSteps = 24;  ///< Over the longer side.
constexpr double kLeastCorrelation = 0.5;
constexpr double kLeastBend = 0.01;     ///< Of the correlation's peak, per square pixel.
constexpr double kLeastContrast = 4.0;  ///< Standard deviation in codes: an eighth of what is usual in the photograph.
constexpr double kPatchInlier_px = 1.5;

cv::Mat as_mat(const ImageU8& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())};
}

/// Reduced from full: pixel centers.
Eigen::Matrix3d reduction(const PhotoFeatures& f) {
  const double sx = static_cast<double>(f.evened.width()) / f.width;
  const double sy = static_cast<double>(f.evened.height()) / f.height;
  Eigen::Matrix3d m;
  m << sx, 0, 0.5 * sx - 0.5, 0, sy, 0.5 * sy - 0.5, 0, 0, 1;
  return m;
}

cv::Mat as_cv(const Eigen::Matrix3d& h) {
  cv::Mat m(3, 3, CV_64F);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m.at<double>(r, c) = h(r, c);
  }
  return m;
}

/// The evened photograph laid over another one, and where it reaches.
struct Laid {
  cv::Mat codes, reached;
};

Laid lay(const PhotoFeatures& from, const Eigen::Matrix3d& to_from, const cv::Size& size) {
  cv::Mat source = as_mat(from.evened);
  const double finer = fineness(to_from, from.evened.width(), from.evened.height());
  constexpr double kFiner = 1.2;
  if (finer > kFiner) cv::GaussianBlur(source, source, {}, 0.5 * std::sqrt(finer * finer - 1.0));
  const cv::Mat whole = from.shown.empty() ? cv::Mat(source.size(), CV_8U, cv::Scalar(255)) : as_mat(from.shown);
  Laid laid;
  cv::warpPerspective(source, laid.codes, as_cv(to_from), size, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  cv::warpPerspective(whole, laid.reached, as_cv(to_from), size, cv::INTER_NEAREST);
  return laid;
}

/// Where a patch of `fixed` around a point lies in `moving`, relative to that point; nothing without a clear peak.
std::optional<Eigen::Vector2d> find_patch(const cv::Mat& fixed, const cv::Mat& moving, const cv::Point& at) {
  const cv::Mat patch = fixed(cv::Rect(at.x - kPatch, at.y - kPatch, 2 * kPatch + 1, 2 * kPatch + 1));
  cv::Scalar mean, deviation;
  cv::meanStdDev(patch, mean, deviation);
  if (!(deviation[0] > kLeastContrast)) return std::nullopt;
  const int half = kPatch + kSearch;
  cv::Mat scores;
  cv::matchTemplate(moving(cv::Rect(at.x - half, at.y - half, 2 * half + 1, 2 * half + 1)), patch, scores,
                    cv::TM_CCOEFF_NORMED);
  const std::optional<ScorePeak> peak = find_score_peak(scores, kLeastCorrelation, kLeastBend);
  if (!peak) return std::nullopt;
  return Eigen::Vector2d(peak->pixel.x() - kSearch, peak->pixel.y() - kSearch) + peak->fraction;
}

/// Matches of points in `fixed` with points in `moving`, both reduced. @param fixed_moving  Fixed from moving.
std::vector<PointMatch> match_patches(const PhotoFeatures& fixed, const PhotoFeatures& moving,
                                      const Eigen::Matrix3d& fixed_moving) {
  const cv::Mat codes = as_mat(fixed.evened);
  const Laid laid = lay(moving, fixed_moving, codes.size());
  cv::Mat usable = laid.reached;
  if (!fixed.shown.empty()) cv::bitwise_and(usable, as_mat(fixed.shown), usable);
  cv::Mat counts;
  cv::integral(usable / 255, counts, CV_32S);
  const Eigen::Matrix3d moving_fixed = fixed_moving.inverse();
  const int half = kPatch + kSearch, step = std::max(kLeastStep, std::max(codes.cols, codes.rows) / kMostSteps);
  constexpr double kMostOutside = 0.15;  // Of a patch: its object may end there.
  const double least = (1.0 - kMostOutside) * (2 * half + 1) * (2 * half + 1);
  std::vector<PointMatch> matches;
  for (int y = half; y < codes.rows - half; y += step) {
    for (int x = half; x < codes.cols - half; x += step) {
      const int x0 = x - half, y0 = y - half, x1 = x + half + 1, y1 = y + half + 1;
      const int covered =
          counts.at<int>(y1, x1) - counts.at<int>(y0, x1) - counts.at<int>(y1, x0) + counts.at<int>(y0, x0);
      if (static_cast<double>(covered) < least) continue;
      const auto shift = find_patch(codes, laid.codes, {x, y});
      if (!shift) continue;
      const Eigen::Vector2d at(x, y);
      matches.push_back({at, moved_by(moving_fixed, at + *shift)});
    }
  }
  return matches;
}

}  // namespace

PhotoPair align_patches(int a, const PhotoFeatures& of_a, int b, const PhotoFeatures& of_b,
                        const Eigen::Matrix3d& b_from_a, AlignModel model) {
  PhotoPair pair{.a = a, .b = b};
  const Eigen::Matrix3d reduced_a = reduction(of_a), reduced_b = reduction(of_b);
  const Eigen::Matrix3d reduced = reduced_b * b_from_a * reduced_a.inverse();
  if (!reduced.allFinite() || !(std::abs(reduced.determinant()) > 1e-9)) return pair;
  const Eigen::Matrix3d full_a = reduced_a.inverse(), full_b = reduced_b.inverse();
  std::vector<PointMatch> matches;
  if (fineness(reduced, of_a.evened.width(), of_a.evened.height()) >= 1.0) {
    for (const PointMatch& m : match_patches(of_b, of_a, reduced))
      matches.push_back({moved_by(full_a, m.in_b), moved_by(full_b, m.in_a)});
  } else {
    for (const PointMatch& m : match_patches(of_a, of_b, reduced.inverse()))
      matches.push_back({moved_by(full_a, m.in_a), moved_by(full_b, m.in_b)});
  }
  const double window = 2.0 * kSearch / of_b.scale;
  judge_matches(matches, of_a, of_b, model, {.inlier_px = kPatchInlier_px / of_b.scale, .area_px2 = window * window},
                pair);
  return pair;
}

}  // namespace patinate::capture
