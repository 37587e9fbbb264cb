#include "capture/handheld/photo_pair.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

constexpr double kSearchInlier_px = 4.0;  ///< In pixels of the search; two reductions and a surface that ages.
constexpr double kLogChance = -6.0;       ///< Decimal, of views expected by chance.
constexpr std::size_t kLeastPlaces = 10;  ///< That agree.
constexpr double kPlace_px = 3.0;         ///< One detail is often found several times.
constexpr double kMinSpread = 0.05;       ///< Share of the smaller photograph's shorter side, standard deviation.
constexpr double kMaxScale = 16.0;        ///< Scale of one photograph against the other.
constexpr double kMaxPerspective = 4.0;   ///< Ratio of scales at two corners of one photograph.

Eigen::Matrix3d invalid() { return Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN()); }

/// Moves the points' mean to 0 and their mean distance from it to 1.
Eigen::Matrix3d conditioner(const std::vector<PointMatch>& matches, Eigen::Vector2d PointMatch::*which) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const PointMatch& m : matches) mean += m.*which;
  mean /= static_cast<double>(matches.size());
  double size = 0.0;
  for (const PointMatch& m : matches) size += (m.*which - mean).norm();
  const double s = 1.0 / std::max(1e-9, size / static_cast<double>(matches.size()));
  Eigen::Matrix3d c;
  c << s, 0, -s * mean.x(), 0, s, -s * mean.y(), 0, 0, 1;
  return c;
}

double squared_error(const Eigen::Matrix3d& h, const std::vector<PointMatch>& matches) {
  double sum = 0.0;
  for (const PointMatch& m : matches) sum += (moved_by(h, m.in_a) - m.in_b).squaredNorm();
  return sum;
}

/// Least squares with Cauchy weights, which a few wrong matches cannot move.
template <class Fit>
Eigen::Matrix3d fit_robustly(const std::vector<PointMatch>& matches, double inlier_px, Fit fit,
                             std::vector<PointMatch>& agreeing) {
  agreeing = matches;
  Eigen::Matrix3d h = fit(agreeing);
  constexpr int kRounds = 4;  // Rounds of agreeing pairs and fit.
  for (int round = 0; round < kRounds && h.allFinite(); ++round) {
    std::vector<double> errors;
    for (const PointMatch& m : agreeing) errors.push_back((moved_by(h, m.in_a) - m.in_b).norm());
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
    // 2.5 standard deviations of what the median tells, which 95 % of Gaussian pairs of errors keep.
    const double limit = std::clamp(2.1 * errors[errors.size() / 2], 0.1 * inlier_px, inlier_px);
    std::vector<PointMatch> kept;
    for (const PointMatch& m : matches) {
      if ((moved_by(h, m.in_a) - m.in_b).norm() <= limit) kept.push_back(m);
    }
    if (kept.size() < kLeastPlaces) break;
    agreeing = std::move(kept);
    h = fit(agreeing);
  }
  return h;
}

/// One match a place.
std::vector<PointMatch> distinct_places(const std::vector<PointMatch>& matches, double distance_px) {
  std::vector<PointMatch> places;
  for (const PointMatch& m : matches) {
    const bool is_known = std::any_of(places.begin(), places.end(),
                                      [&](const PointMatch& p) { return (p.in_b - m.in_b).norm() < distance_px; });
    if (!is_known) places.push_back(m);
  }
  return places;
}

/// Decimal logarithm of the number of views, determined by `sample` of `count` matches, on which `agreeing` or more
/// agree though every match lies anywhere.
double log_chance(std::size_t count, std::size_t agreeing, std::size_t sample, double share) {
  if (agreeing <= sample) return 0.0;
  const auto log_choose = [](double n, double k) {
    return (std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1)) / std::numbers::ln10;
  };
  const double n = static_cast<double>(count), k = static_cast<double>(agreeing), s = static_cast<double>(sample);
  return std::log10(n) + log_choose(n, k) + log_choose(k, s) + (k - s) * std::log10(std::min(1.0, share));
}

double smaller_spread(const std::vector<PointMatch>& matches, Eigen::Vector2d PointMatch::*which) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const PointMatch& m : matches) mean += m.*which;
  mean /= static_cast<double>(matches.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const PointMatch& m : matches) scatter += (m.*which - mean) * (m.*which - mean).transpose();
  scatter /= static_cast<double>(matches.size());
  const double half = 0.5 * scatter.trace();
  return std::sqrt(std::max(0.0, half - std::sqrt(std::max(0.0, half * half - scatter.determinant()))));
}

/// Length of a pixel of a, in pixels of b.
double scale_at(const Eigen::Matrix3d& h, const Eigen::Vector2d& p) {
  const double z = h.row(2).dot(p.homogeneous());
  const double area = h.determinant() / (z * z * z);
  return area > 0.0 && z > 0.0 ? std::sqrt(area) : 0.0;
}

std::array<Eigen::Vector2d, 4> corners_of(const PhotoFeatures& f) {
  return {Eigen::Vector2d(0, 0), Eigen::Vector2d(f.width - 1.0, 0), Eigen::Vector2d(f.width - 1.0, f.height - 1.0),
          Eigen::Vector2d(0, f.height - 1.0)};
}

/// The whole photograph lies before the camera, is not mirrored, and its corners are of like scale.
bool is_plausible(const Eigen::Matrix3d& h, const PhotoFeatures& a) {
  if (!h.allFinite()) return false;
  double least = 1e300, most = 0.0;
  for (const Eigen::Vector2d& corner : corners_of(a)) {
    const double scale = scale_at(h, corner);
    least = std::min(least, scale);
    most = std::max(most, scale);
  }
  return least > 1.0 / kMaxScale && most < kMaxScale && most < kMaxPerspective * least;
}

std::vector<PointMatch> chosen(const std::vector<PointMatch>& matches, const std::vector<unsigned char>& is_chosen) {
  std::vector<PointMatch> result;
  for (std::size_t i = 0; i < matches.size() && i < is_chosen.size(); ++i) {
    if (is_chosen[i] != 0) result.push_back(matches[i]);
  }
  return result;
}

/// Matches that agree on the view that RANSAC or MAGSAC finds.
std::vector<PointMatch> consensus(const std::vector<PointMatch>& matches, bool is_homography, double inlier_px) {
  std::vector<cv::Point2f> from, to;
  for (const PointMatch& m : matches) {
    from.emplace_back(static_cast<float>(m.in_a.x()), static_cast<float>(m.in_a.y()));
    to.emplace_back(static_cast<float>(m.in_b.x()), static_cast<float>(m.in_b.y()));
  }
  constexpr std::size_t kRounds = 10000;
  constexpr double kSure = 0.9999;  // RANSAC's confidence.
  std::vector<unsigned char> is_inlier;
  if (is_homography) {
    (void)cv::findHomography(from, to, cv::USAC_MAGSAC, inlier_px, is_inlier, static_cast<int>(kRounds), kSure);
  } else {
    (void)cv::estimateAffinePartial2D(from, to, is_inlier, cv::RANSAC, inlier_px, kRounds, kSure);
  }
  return chosen(matches, is_inlier);
}

/// Matches spread over the picture: of every cell of a grid the first ones, in turn.
std::vector<PointMatch> thinned(const std::vector<PointMatch>& matches, const PhotoFeatures& b) {
  if (matches.size() <= kMaxKept) return matches;
  constexpr int kCells = 9;  // Cells along a side; matches are thinned evenly over them.
  std::vector<std::vector<PointMatch>> cells(kCells * kCells);
  for (const PointMatch& m : matches) {
    const int x = std::clamp(static_cast<int>(kCells * m.in_b.x() / b.width), 0, kCells - 1);
    const int y = std::clamp(static_cast<int>(kCells * m.in_b.y() / b.height), 0, kCells - 1);
    cells[y * kCells + x].push_back(m);
  }
  std::vector<PointMatch> result;
  for (std::size_t turn = 0; result.size() < kMaxKept; ++turn) {
    for (const auto& cell : cells) {
      if (turn < cell.size() && result.size() < kMaxKept) result.push_back(cell[turn]);
    }
  }
  return result;
}

/// Whether a homography explains the matches better than its four further numbers can by chance, and by enough to
/// matter.
bool is_refuted(const Eigen::Matrix3d& similarity, const Eigen::Matrix3d& homography,
                const std::vector<PointMatch>& matches, double least_px) {
  constexpr double kMinF = 8.0;  // Value of F(4, many) that chance exceeds once in a million.
  const double rest = 2.0 * static_cast<double>(matches.size()) - 8.0;
  if (rest < 8.0) return false;
  const double simple = squared_error(similarity, matches), full = squared_error(homography, matches);
  if (!(simple - full > kMinF * 4.0 * full / rest)) return false;
  double most = 0.0;
  for (const PointMatch& m : matches)
    most = std::max(most, (moved_by(similarity, m.in_a) - moved_by(homography, m.in_a)).norm());
  return most > least_px;
}

}  // namespace

Eigen::Matrix3d fit_similarity(const std::vector<PointMatch>& matches) {
  if (matches.size() < 2) return invalid();
  // With points as complex numbers: q - mean(q) = s (p - mean(p)).
  using Complex = std::complex<double>;
  const auto number = [](const Eigen::Vector2d& p) { return Complex(p.x(), p.y()); };
  const double count = static_cast<double>(matches.size());
  Complex mean_a, mean_b, product;
  double square = 0.0;
  for (const PointMatch& m : matches) {
    mean_a += number(m.in_a) / count;
    mean_b += number(m.in_b) / count;
  }
  for (const PointMatch& m : matches) {
    product += std::conj(number(m.in_a) - mean_a) * (number(m.in_b) - mean_b);
    square += std::norm(number(m.in_a) - mean_a);
  }
  if (!(square > 0.0) || !(std::abs(product) > 0.0)) return invalid();
  const Complex s = product / square, t = mean_b - s * mean_a;
  Eigen::Matrix3d h;
  h << s.real(), -s.imag(), t.real(), s.imag(), s.real(), t.imag(), 0, 0, 1;
  return h;
}

Eigen::Matrix3d fit_homography(const std::vector<PointMatch>& matches) {
  if (matches.size() < 4) return invalid();
  const Eigen::Matrix3d ca = conditioner(matches, &PointMatch::in_a), cb = conditioner(matches, &PointMatch::in_b);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (const PointMatch& m : matches) {
    const Eigen::Vector3d p = ca * m.in_a.homogeneous();
    const Eigen::Vector2d q = (cb * m.in_b.homogeneous()).hnormalized();
    Eigen::Matrix<double, 2, 9> rows = Eigen::Matrix<double, 2, 9>::Zero();
    rows.block<1, 3>(0, 0) = p.transpose();
    rows.block<1, 3>(0, 6) = -q.x() * p.transpose();
    rows.block<1, 3>(1, 3) = p.transpose();
    rows.block<1, 3>(1, 6) = -q.y() * p.transpose();
    normal += rows.transpose() * rows;
  }
  const RightSingular svd = right_singular(normal);
  if (!(svd.values(7) > 1e-12 * svd.values(0))) return invalid();
  const Eigen::VectorXd v = svd.vectors.col(8);
  Eigen::Matrix3d h;
  h << v(0), v(1), v(2), v(3), v(4), v(5), v(6), v(7), v(8);
  h = cb.inverse() * h * ca;
  return h / h(2, 2);
}

void judge_matches(const std::vector<PointMatch>& matches, const PhotoFeatures& of_a, const PhotoFeatures& of_b,
                   AlignModel model, const MatchNoise& noise, PhotoPair& pair) {
  pair.num_matches = static_cast<int>(matches.size());
  if (matches.size() < kLeastPlaces) return;
  std::vector<PointMatch> of_similarity, of_homography;
  Eigen::Matrix3d similarity = invalid(), homography = invalid();
  if (model != AlignModel::Homography) {
    const std::vector<PointMatch> found = consensus(matches, false, noise.inlier_px);
    if (found.size() >= kLeastPlaces) similarity = fit_robustly(found, noise.inlier_px, fit_similarity, of_similarity);
  }
  if (model != AlignModel::Similarity) {
    const std::vector<PointMatch> found = consensus(matches, true, noise.inlier_px);
    if (found.size() >= kLeastPlaces) homography = fit_robustly(found, noise.inlier_px, fit_homography, of_homography);
    if (!is_plausible(homography, of_a)) of_homography.clear();
  }
  if (!is_plausible(similarity, of_a)) of_similarity.clear();
  // A homography follows wrong matches more easily: without a similarity beside it, it needs far more of them.
  constexpr double kMoreByHomography = 1.15;
  constexpr std::size_t kMoreAtLeast = 8;
  const bool has_more =
      static_cast<double>(of_homography.size()) > kMoreByHomography * static_cast<double>(of_similarity.size()) &&
      of_homography.size() > of_similarity.size() + kMoreAtLeast;
  pair.refutes_similarity = !of_homography.empty() &&
                            (of_similarity.empty() || has_more ||
                             is_refuted(fit_similarity(of_homography), homography, of_homography, 1.0 / of_b.scale));
  const std::vector<PointMatch>& agreeing = pair.refutes_similarity ? of_homography : of_similarity;
  pair.b_from_a = pair.refutes_similarity ? homography : similarity;
  pair.num_agreeing = static_cast<int>(agreeing.size());
  const std::size_t sample = pair.refutes_similarity ? 4 : 2;
  const std::vector<PointMatch> places = distinct_places(agreeing, kPlace_px / of_b.scale);
  if (places.size() < kLeastPlaces) return;
  const double share = std::numbers::pi * noise.inlier_px * noise.inlier_px / noise.area_px2;
  const std::size_t num_others = matches.size() - agreeing.size();
  const bool is_no_chance = log_chance(num_others + places.size(), places.size(), sample, share) < kLogChance;
  const bool is_spread = smaller_spread(places, &PointMatch::in_a) > kMinSpread * std::min(of_a.width, of_a.height) ||
                         smaller_spread(places, &PointMatch::in_b) > kMinSpread * std::min(of_b.width, of_b.height);
  pair.is_accepted = is_no_chance && is_spread;
  const double rest = std::max(1.0, 2.0 * static_cast<double>(agreeing.size()) - 2.0 * static_cast<double>(sample));
  pair.error_px = std::max(0.05 / of_b.scale, std::sqrt(squared_error(pair.b_from_a, agreeing) / rest));
  pair.matches = thinned(places, of_b);
}

PhotoPair align_features(int a, const PhotoFeatures& of_a, int b, const PhotoFeatures& of_b, AlignModel model) {
  PhotoPair pair{.a = a, .b = b};
  std::vector<PointMatch> matches;
  for (const auto& [i, j] : match_features(of_a, of_b)) matches.push_back({of_a.points[i], of_b.points[j]});
  const MatchNoise noise{.inlier_px = kSearchInlier_px / of_b.scale,
                         .area_px2 = static_cast<double>(of_b.width) * static_cast<double>(of_b.height)};
  judge_matches(matches, of_a, of_b, model, noise, pair);
  return pair;
}

PhotoPair align_marks(int a, int b, const std::vector<PointMatch>& marks, AlignModel model, double error_px) {
  PhotoPair pair{.a = a, .b = b};
  pair.num_matches = pair.num_agreeing = static_cast<int>(marks.size());
  pair.error_px = error_px;
  pair.is_marked = true;
  pair.matches = marks;
  if (model != AlignModel::Homography) pair.b_from_a = fit_similarity(marks);
  if (model == AlignModel::Homography || (model == AlignModel::Auto && marks.size() >= 4)) {
    const Eigen::Matrix3d homography = fit_homography(marks);
    // Four marks always fit a homography: then only what no careless mark can be refutes the simpler view.
    const double rest = 2.0 * static_cast<double>(marks.size()) - 4.0;
    const double rms_px = pair.b_from_a.allFinite() ? std::sqrt(squared_error(pair.b_from_a, marks) / rest) : 1e300;
    pair.refutes_similarity = homography.allFinite() && (model == AlignModel::Homography || rms_px > 3.0 * error_px);
    if (pair.refutes_similarity) pair.b_from_a = homography;
    if (model == AlignModel::Homography && !homography.allFinite()) return pair;
  }
  pair.is_accepted = pair.b_from_a.allFinite() && pair.b_from_a.determinant() > 0.0;
  return pair;
}

double carried_error_px(const PhotoPair& pair, double width, double height) {
  const Eigen::Matrix3d from_conditioned = conditioner(pair.matches, &PointMatch::in_a).inverse();
  Eigen::Matrix3d h = pair.b_from_a * from_conditioned;
  h /= h(2, 2);
  const Eigen::Index n = pair.refutes_similarity ? 8 : 4;
  const auto rows_at = [&](const Eigen::Vector2d& in_a) {
    const Eigen::Vector2d p = (from_conditioned.inverse() * in_a.homogeneous()).hnormalized();
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, n);
    if (n == 4) {
      rows << p.x(), -p.y(), 1, 0, p.y(), p.x(), 0, 1;
      return rows;
    }
    const Eigen::Vector2d q = moved_by(h, p);
    rows.block<1, 3>(0, 0) = rows.block<1, 3>(1, 3) = p.homogeneous().transpose();
    rows.block<2, 2>(0, 6) = -q * p.transpose();
    return Eigen::MatrixXd(rows / (h(2, 0) * p.x() + h(2, 1) * p.y() + 1.0));
  };
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  for (const PointMatch& m : pair.matches) {
    const Eigen::MatrixXd rows = rows_at(m.in_a);
    information += rows.transpose() * rows;
  }
  const Eigen::MatrixXd covariance = pair.error_px * pair.error_px * inverse_by_lu(information);
  double sum = 0.0;
  for (const double x : {0.0, width - 1.0}) {
    for (const double y : {0.0, height - 1.0}) {
      const Eigen::MatrixXd rows = rows_at({x, y});
      sum += (rows * covariance * rows.transpose()).trace() / 4.0;
    }
  }
  return std::sqrt(sum);
}

}  // namespace patinate::capture
