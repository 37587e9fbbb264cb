#include "capture/handheld/align_series.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <utility>

#include "capture/alignment/score_peak.h"
#include "capture/handheld/lay_photo.h"
#include "capture/handheld/photo_pair.h"
#include "libcommon/core/parallel.h"

namespace patinate::capture {

namespace {

constexpr int kPatch = 20;               ///< Half side.
constexpr int kSearch = 6;               ///< px that a patch is searched in each direction.
constexpr int kMinStep = 12;             ///< Least px between patches.
constexpr int kMostSteps = 24;           ///< Over the longer side.
constexpr double kMinCorrelation = 0.5;  ///< Normalized correlation that a patch needs to be found.
constexpr double kMinBend = 0.01;        ///< Bend of the correlation's peak, per square pixel.
constexpr double kMinContrast = 4.0;     ///< Standard deviation in codes: an eighth of what is usual in the photograph.
constexpr double kPatchInlier_px = 1.5;  ///< Distance within which patches agree, px of the matched size.

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
  constexpr double kFiner = 1.2;  // A photograph this much finer is blurred before it is resampled.
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
  if (!(deviation[0] > kMinContrast)) return std::nullopt;
  const int half = kPatch + kSearch;
  cv::Mat scores;
  cv::matchTemplate(moving(cv::Rect(at.x - half, at.y - half, 2 * half + 1, 2 * half + 1)), patch, scores,
                    cv::TM_CCOEFF_NORMED);
  const std::optional<ScorePeak> peak = find_score_peak(scores, kMinCorrelation, kMinBend);
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
  const int half = kPatch + kSearch, step = std::max(kMinStep, std::max(codes.cols, codes.rows) / kMostSteps);
  constexpr double kMaxOutside = 0.15;  // Share of a patch: its object may end there.
  const double least = (1.0 - kMaxOutside) * (2 * half + 1) * (2 * half + 1);
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

/// Pair from patches: the finer photograph is laid over the other one, and patches of 41 pixels, all over what both
/// show, find their own shifts of up to 6 px by normalized cross-correlation; then as judge_matches(). In pixels of the
/// reduced photographs (PhotoFeatures::evened).
/// @param b_from_a  What is known of it.
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

using IndexPair = std::pair<int, int>;

RunControl silent(const RunControl& control) {
  const RunControl quiet = control.silent();
  return quiet;
}

class SeriesMatcher {
 public:
  SeriesMatcher(const PhotoSeries& series, const RunControl& control)
      : series_(series), control_(control), num_photos_(static_cast<int>(series.sizes.size())) {}

  SeriesAlignment run() {
    add_marks();
    if (series_.outlines && !series_.features) add_outlines();
    if (series_.features) {
      find_all_features();
      control_.report(0.5);
      match(first_pairs());
      control_.report(0.8);
    }
    SeriesAlignment result = place();
    constexpr int kRounds = 3;  // A photograph that is tied now may tie others.
    for (int round = 0; round < kRounds && series_.features && tie_the_rest(); ++round) result = place();
    if (series_.features && series_.outlines && !all_tied()) {
      tried_.clear();
      add_outlines();
      result = place();
    }
    control_.report(0.9);
    constexpr int kExactRounds = 2;  // The second starts where the first has come.
    for (int round = 0; round < kExactRounds && series_.features; ++round) {
      make_exact(result);
      result = place();
    }
    control_.report(1.0);
    return result;
  }

 private:
  [[nodiscard]] bool is_given(int photo) const {
    return photo == series_.reference || series_.given[photo].has_value();
  }

  void add_marks() {
    if (series_.marks.empty()) return;
    for (int a = 0; a < num_photos_; ++a) {
      for (int b = a + 1; b < num_photos_; ++b) {
        if (is_given(a) && is_given(b)) continue;
        const std::vector<PointMatch> shared = shared_marks(series_.marks[a], series_.marks[b]);
        if (shared.size() < 2) continue;
        pairs_.push_back(align(a, b, shared));
      }
    }
  }

  [[nodiscard]] PhotoPair align(int a, int b, const std::vector<PointMatch>& shared) const {
    const PhotoSize& from = series_.sizes[a];
    const PhotoSize& to = series_.sizes[b];
    if (!series_.are_marks_exact)
      return align_marks(a, b, shared, series_.model, mark_error_px(std::max(to.width, to.height)));
    constexpr double kExact_px = 0.25, kMaxCarried = 0.01;  // Share of the longer side.
    PhotoPair pair = align_marks(a, b, shared, series_.model, kExact_px);
    if (pair.is_accepted) {
      pair.is_accepted = carried_error_px(pair, from.width, from.height) < kMaxCarried * std::max(to.width, to.height);
    }
    return pair;
  }

  void add_outlines() {
    std::vector<PhotoOutline> outlines(static_cast<std::size_t>(num_photos_));
    parallel_for(num_photos_, 1, silent(control_), [&](std::int64_t begin, std::int64_t) {
      outlines[begin] = series_.outlines(static_cast<int>(begin));
    });
    if (!series_.features) control_.report(0.5);
    match(first_pairs(), [&](int a, int b) { return align_outlines(a, outlines[a], b, outlines[b]); });
  }

  void find_all_features() {
    features_.resize(num_photos_);
    parallel_for(num_photos_, 1, silent(control_), [&](std::int64_t begin, std::int64_t) {
      features_[begin] = series_.features(static_cast<int>(begin));
    });
  }

  [[nodiscard]] std::set<IndexPair> first_pairs() const {
    constexpr int kAllPairs = 10;  // Series of up to so many photographs match all pairs.
    std::set<IndexPair> wanted;
    const auto add = [&](int a, int b) {
      if (a != b && a >= 0 && b < num_photos_) wanted.emplace(std::min(a, b), std::max(a, b));
    };
    for (int a = 0; a < num_photos_; ++a) {
      for (int b = a + 1; b < num_photos_ && num_photos_ <= kAllPairs; ++b) add(a, b);
      add(a, a + 1);
      if (a + 2 < num_photos_) add(a, a + 2);
      add(a, series_.reference);
      add(a, num_photos_ / 2);
    }
    wanted.erase({num_photos_ - 1, num_photos_});
    return wanted;
  }

  void match(const std::set<IndexPair>& wanted) {
    match(wanted, [&](int a, int b) { return align_features(a, features_[a], b, features_[b], series_.model); });
  }

  /// @param align  align(a, b); thread-safe.
  template <class Align>
  void match(const std::set<IndexPair>& wanted, const Align& align) {
    std::vector<IndexPair> list;
    for (const IndexPair& p : wanted) {
      if (p.second < num_photos_ && !(is_given(p.first) && is_given(p.second)) && tried_.insert(p).second)
        list.push_back(p);
    }
    std::vector<PhotoPair> found(list.size());
    parallel_for(static_cast<std::int64_t>(list.size()), 1, silent(control_), [&](std::int64_t begin, std::int64_t) {
      const std::size_t i = begin;
      found[i] = align(list[i].first, list[i].second);
    });
    pairs_.insert(pairs_.end(), found.begin(), found.end());
  }

  [[nodiscard]] SeriesAlignment place() const {
    SeriesAlignment result;
    result.pairs = pairs_;
    result.places = place_photos(series_.sizes, series_.reference, series_.given, result.pairs, series_.model);
    last_kept_ = result.pairs;
    return result;
  }

  [[nodiscard]] std::vector<bool> tied() const {
    std::vector<int> roots;
    for (int i = 0; i < num_photos_; ++i) {
      if (is_given(i)) roots.push_back(i);
    }
    return tied_to(num_photos_, roots, last_kept_);
  }

  [[nodiscard]] bool all_tied() const {
    const std::vector<bool> is_tied = tied();
    return std::all_of(is_tied.begin(), is_tied.end(), [](bool t) { return t; });
  }

  /// @returns Whether a pair was found that may tie a photograph.
  bool tie_the_rest() {
    // Nearest in time that a photograph without a pair is tried against (docs/algorithms/handheld.md).
    constexpr std::size_t kMaxTried = 24;
    const std::vector<bool> is_tied = tied();
    const std::size_t before = pairs_.size();
    bool is_any = false;
    for (int i = 0; i < num_photos_; ++i) {
      if (is_tied[i]) continue;
      std::vector<int> others;
      for (int j = 0; j < num_photos_; ++j) {
        if (is_tied[j]) others.push_back(j);
      }
      std::stable_sort(others.begin(), others.end(), [i](int a, int b) { return std::abs(a - i) < std::abs(b - i); });
      if (others.size() > kMaxTried) others.resize(kMaxTried);
      std::set<IndexPair> wanted;
      for (int j : others) wanted.emplace(std::min(i, j), std::max(i, j));
      match(wanted);
    }
    for (std::size_t k = before; k < pairs_.size(); ++k) is_any = is_any || pairs_[k].is_accepted;
    return is_any;
  }

  /// Matches patches of the pairs that fit by features, and of all photographs with the reference, where they are
  /// known to lie now; those that fit take the features' place.
  void make_exact(const SeriesAlignment& now) {
    std::set<IndexPair> wanted;
    for (const PhotoPair& pair : last_kept_) {
      if (pair.is_accepted) wanted.emplace(pair.a, pair.b);
    }
    for (int i = 0; i < num_photos_; ++i) {
      if (i != series_.reference) wanted.emplace(std::min(i, series_.reference), std::max(i, series_.reference));
    }
    std::vector<IndexPair> list;
    for (const auto& [a, b] : wanted) {
      const bool is_known =
          place_of(now, a).status != PlaceStatus::Failed && place_of(now, b).status != PlaceStatus::Failed;
      if (is_known && !(is_given(a) && is_given(b))) list.emplace_back(a, b);
    }
    std::vector<PhotoPair> found(list.size());
    parallel_for(static_cast<std::int64_t>(list.size()), 1, silent(control_), [&](std::int64_t begin, std::int64_t) {
      const auto [a, b] = list[begin];
      const Eigen::Matrix3d b_from_a =
          place_of(now, b).reference_from_photo.inverse() * place_of(now, a).reference_from_photo;
      found[begin] = align_patches(a, features_[a], b, features_[b], b_from_a, series_.model);
    });
    pairs_ = last_kept_;
    for (PhotoPair& pair : found) {
      if (!pair.is_accepted) continue;
      std::erase_if(pairs_, [&](const PhotoPair& p) { return p.a == pair.a && p.b == pair.b && !p.is_marked; });
      pairs_.push_back(std::move(pair));
    }
  }

  [[nodiscard]] const PhotoPlace& place_of(const SeriesAlignment& alignment, int photo) const {
    return alignment.places[photo];
  }

  const PhotoSeries& series_;
  const RunControl& control_;
  int num_photos_;
  std::vector<PhotoFeatures> features_;
  std::vector<PhotoPair> pairs_;
  mutable std::vector<PhotoPair> last_kept_;  ///< pairs_, of which wrong ones are no longer accepted.
  std::set<IndexPair> tried_;
};

}  // namespace

SeriesAlignment align_series(const PhotoSeries& series, const RunControl& control) {
  return SeriesMatcher(series, control).run();
}

}  // namespace patinate::capture
