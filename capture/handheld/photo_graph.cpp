#include "capture/handheld/photo_graph.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>

namespace patinate::capture {

namespace {

constexpr int kMaxRounds = 40;        ///< Most rounds of least squares; five do as a rule.
constexpr double kCauchy = 2.0;       ///< Disagreements beyond so many errors count less.
constexpr double kDropErrors = 4.0;   ///< A pair that disagrees by more of its errors ...
constexpr double kDropMedians = 3.0;  ///< ... and of the median pair is wrong.

/// Maps a photograph to about [-1, 1], so that all numbers of a place are of one size.
Eigen::Matrix3d normalizer(const PhotoSize& size) {
  const double s = 2.0 / std::max(size.width, size.height);
  Eigen::Matrix3d n;
  n << s, 0, -0.5 * s * (size.width - 1), 0, s, -0.5 * s * (size.height - 1), 0, 0, 1;
  return n;
}

/// A photograph's place while it is sought: 4 or 8 numbers, or none where it is known.
struct Node {
  Eigen::Matrix3d place = Eigen::Matrix3d::Identity();  ///< Normalized reference from normalized photograph.
  bool is_known = false, is_reached = false;
  int parent = -1, depth = 0;
  int num_numbers = 4, first = -1;

  [[nodiscard]] Eigen::Matrix3d changed(int number, double by) const {
    Eigen::Matrix3d p = place;
    if (num_numbers == 8) {
      p(number / 3, number % 3) += by;
      return p;
    }
    // A similarity: [a -b x; b a y].
    if (number == 0) p(0, 0) += by, p(1, 1) += by;
    if (number == 1) p(0, 1) -= by, p(1, 0) += by;
    if (number == 2) p(0, 2) += by;
    if (number == 3) p(1, 2) += by;
    return p;
  }
};

class PhotoGraph {
 public:
  PhotoGraph(const std::vector<PhotoSize>& sizes, int reference,
             const std::vector<std::optional<Eigen::Matrix3d>>& given, std::vector<PhotoPair>& pairs, AlignModel model)
      : sizes_(sizes), reference_(reference), pairs_(pairs), nodes_(sizes.size()) {
    for (const PhotoSize& size : sizes) normalizers_.push_back(normalizer(size));
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      if (static_cast<int>(i) == reference) nodes_[i].is_known = true;
      if (given[i]) {
        nodes_[i].is_known = true;
        nodes_[i].place = in_normalized(static_cast<int>(i), *given[i]);
      }
      choose_model(static_cast<int>(i), model);
    }
  }

  void solve() {
    constexpr int kMaxDrops = 8;
    for (int turn = 0; turn < kMaxDrops; ++turn) {
      plant_tree();
      // A tree over a wrong pair starts far off: at first all count, then those that the others contradict ever less.
      scale_ = std::max(kCauchy, worst_disagreement());
      for (int round = 0; round < kMaxRounds; ++round) {
        const double change = improve();
        if (change < 1e-9 && scale_ == kCauchy) break;
        scale_ = std::max(kCauchy, 0.5 * scale_);
      }
      if (!drop_worst()) return;
    }
  }

  [[nodiscard]] std::vector<PhotoPlace> places() const {
    std::vector<PhotoPlace> places;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      PhotoPlace place;
      place.model = node.num_numbers == 8 ? AlignModel::Homography : AlignModel::Similarity;
      if (node.is_reached) {
        const Eigen::Matrix3d h = normalizers_[reference_].inverse() * node.place * normalizers_[i];
        place.reference_from_photo = h / h(2, 2);
        place.status = status_of(static_cast<int>(i), place.through);
      }
      places.push_back(place);
    }
    measure_residuals(places);
    return places;
  }

 private:
  [[nodiscard]] Eigen::Matrix3d in_normalized(int photo, const Eigen::Matrix3d& reference_from_photo) const {
    const Eigen::Matrix3d p = normalizers_[reference_] * reference_from_photo * normalizers_[photo].inverse();
    return p / p(2, 2);
  }

  void choose_model(int photo, AlignModel model) {
    Node& node = nodes_[photo];
    int num_pairs = 0, num_refuting = 0;
    for (const PhotoPair& pair : pairs_) {
      if (!pair.is_accepted || (pair.a != photo && pair.b != photo)) continue;
      ++num_pairs;
      num_refuting += pair.refutes_similarity ? 1 : 0;
    }
    const bool is_refuted = num_refuting > 0 && 2 * num_refuting >= num_pairs;
    const bool is_tilted = model == AlignModel::Homography || (model == AlignModel::Auto && is_refuted);
    node.num_numbers = is_tilted ? 8 : 4;
  }

  /// First places: over the pairs with most support, from what is known outwards.
  void plant_tree() {
    for (Node& node : nodes_) node.is_reached = node.is_known;
    while (true) {
      const PhotoPair* best = nullptr;
      for (const PhotoPair& pair : pairs_) {
        if (!pair.is_accepted || node_of(pair.a).is_reached == node_of(pair.b).is_reached) continue;
        if (best == nullptr || pair.num_agreeing > best->num_agreeing) best = &pair;
      }
      if (best == nullptr) break;
      const bool is_forth = node_of(best->b).is_reached;
      const int from = is_forth ? best->b : best->a, to = is_forth ? best->a : best->b;
      const Eigen::Matrix3d from_to = is_forth ? best->b_from_a : best->b_from_a.inverse().eval();
      Node& node = node_of(to);
      const std::size_t k = static_cast<std::size_t>(from), m = static_cast<std::size_t>(to);
      node.place = node_of(from).place * normalizers_[k] * from_to * normalizers_[m].inverse();
      node.place /= node.place(2, 2);
      if (node.num_numbers == 4) node.place = as_similarity(node.place);
      node.is_reached = true;
      node.parent = from;
      node.depth = node_of(from).depth + 1;
    }
    int first = 0;
    for (Node& node : nodes_) {
      node.first = node.is_reached && !node.is_known ? first : -1;
      if (node.first >= 0) first += node.num_numbers;
    }
    num_numbers_ = first;
  }

  [[nodiscard]] static Eigen::Matrix3d as_similarity(const Eigen::Matrix3d& place) {
    std::vector<PointMatch> corners;
    for (double x : {-1.0, 1.0}) {
      for (double y : {-1.0, 1.0}) corners.push_back({{x, y}, moved_by(place, {x, y})});
    }
    return fit_similarity(corners);
  }

  /// Disagreement of a match in b's pixels, over the pair's error.
  [[nodiscard]] Eigen::Vector2d residual(const PhotoPair& pair, const Eigen::Matrix3d& b_from_a,
                                         const PointMatch& match) const {
    return (moved_by(b_from_a, match.in_a) - match.in_b) / pair.error_px;
  }
  [[nodiscard]] Eigen::Matrix3d b_from_a(const PhotoPair& pair, const Eigen::Matrix3d& a,
                                         const Eigen::Matrix3d& b) const {
    return normalizers_[pair.b].inverse() * b.inverse() * a * normalizers_[pair.a];
  }

  /// One round of reweighted Gauss-Newton. @returns The largest change of a number.
  double improve() {
    if (num_numbers_ == 0) return 0.0;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(num_numbers_);
    for (int i = 0; i < num_numbers_; ++i) entries.emplace_back(i, i, 1e-9);
    for (const PhotoPair& pair : pairs_) {
      if (pair.is_accepted && node_of(pair.a).is_reached) add_pair(pair, entries, right);
    }
    Eigen::SparseMatrix<double> normal(num_numbers_, num_numbers_);
    normal.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
    const Eigen::VectorXd step = solver.solve(right);
    if (solver.info() != Eigen::Success || !step.allFinite()) return 0.0;
    for (Node& node : nodes_) {
      if (node.first < 0) continue;
      for (int k = 0; k < node.num_numbers; ++k) node.place = node.changed(k, step(node.first + k));
    }
    return step.cwiseAbs().maxCoeff();
  }

  void add_pair(const PhotoPair& pair, std::vector<Eigen::Triplet<double>>& entries, Eigen::VectorXd& right) const {
    constexpr double kStep = 1e-6;  // Step of numeric derivatives.
    const Node &a = node_of(pair.a), &b = node_of(pair.b);
    const Eigen::Matrix3d now = b_from_a(pair, a.place, b.place);
    std::vector<int> numbers;
    std::vector<Eigen::Matrix3d> changed;
    for (const Node* node : {&a, &b}) {
      if (node->first < 0) continue;
      for (int k = 0; k < node->num_numbers; ++k) {
        numbers.push_back(node->first + k);
        changed.push_back(node == &a ? b_from_a(pair, a.changed(k, kStep), b.place)
                                     : b_from_a(pair, a.place, b.changed(k, kStep)));
      }
    }
    const Eigen::Index count = static_cast<Eigen::Index>(numbers.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(count);
    for (const PointMatch& match : pair.matches) {
      const Eigen::Vector2d r = residual(pair, now, match);
      const double weight = 1.0 / (1.0 + r.squaredNorm() / (scale_ * scale_));
      Eigen::Matrix2Xd slope(2, count);
      for (Eigen::Index k = 0; k < count; ++k) slope.col(k) = (residual(pair, changed[k], match) - r) / kStep;
      normal += weight * slope.transpose() * slope;
      gradient -= weight * slope.transpose() * r;
    }
    for (Eigen::Index k = 0; k < count; ++k) {
      right(numbers[k]) += gradient(k);
      for (Eigen::Index m = 0; m < count; ++m) entries.emplace_back(numbers[k], numbers[m], normal(k, m));
    }
  }

  /// Median disagreement of its matches, in its errors.
  [[nodiscard]] double disagreement(const PhotoPair& pair) const {
    const Eigen::Matrix3d h = b_from_a(pair, node_of(pair.a).place, node_of(pair.b).place);
    std::vector<double> sizes;
    for (const PointMatch& match : pair.matches) sizes.push_back(residual(pair, h, match).norm());
    if (sizes.empty()) return 0.0;
    std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
    return sizes[sizes.size() / 2];
  }

  [[nodiscard]] double worst_disagreement() const {
    double worst = 0.0;
    for (const PhotoPair& pair : pairs_) {
      if (pair.is_accepted && node_of(pair.a).is_reached) worst = std::max(worst, disagreement(pair));
    }
    return std::min(worst, 1e6);
  }

  bool drop_worst() {
    std::vector<double> all;
    for (const PhotoPair& pair : pairs_) {
      if (pair.is_accepted && node_of(pair.a).is_reached) all.push_back(disagreement(pair));
    }
    if (all.size() < 3) return false;  // Two pairs cannot say which of them is wrong.
    std::vector<double> sorted = all;
    std::sort(sorted.begin(), sorted.end());
    const double limit = std::max(kDropErrors, kDropMedians * sorted[sorted.size() / 2]);
    if (!(sorted.back() > limit)) return false;
    // The worse half of what is over: right pairs are pulled along by wrong ones.
    const double cut = std::max(limit, 0.5 * sorted.back());
    for (PhotoPair& pair : pairs_) {
      if (pair.is_accepted && node_of(pair.a).is_reached && disagreement(pair) > cut) pair.is_accepted = false;
    }
    return true;
  }

  [[nodiscard]] PlaceStatus status_of(int photo, int& through) const {
    if (photo == reference_) return PlaceStatus::Reference;
    const Node& node = node_of(photo);
    if (node.is_known) return PlaceStatus::Given;
    const bool is_direct = std::any_of(pairs_.begin(), pairs_.end(), [&](const PhotoPair& pair) {
      return pair.is_accepted &&
             ((pair.a == photo && pair.b == reference_) || (pair.b == photo && pair.a == reference_));
    });
    if (is_direct) return PlaceStatus::Aligned;
    through = node.parent;
    return PlaceStatus::Through;
  }

  void measure_residuals(std::vector<PhotoPlace>& places) const {
    std::vector<double> sums(places.size(), 0.0), counts(places.size(), 0.0);
    for (const PhotoPair& pair : pairs_) {
      if (!pair.is_accepted || !node_of(pair.a).is_reached) continue;
      const std::size_t a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
      ++places[a].num_pairs;
      ++places[b].num_pairs;
      for (const PointMatch& match : pair.matches) {
        const double d = (moved_by(places[a].reference_from_photo, match.in_a) -
                          moved_by(places[b].reference_from_photo, match.in_b))
                             .squaredNorm();
        for (std::size_t k : {a, b}) {
          sums[k] += d;
          counts[k] += 1.0;
        }
      }
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (counts[i] > 0.0) places[i].residual_px = std::sqrt(sums[i] / counts[i]);
    }
  }

  [[nodiscard]] const Node& node_of(int photo) const { return nodes_[photo]; }
  [[nodiscard]] Node& node_of(int photo) { return nodes_[photo]; }

  const std::vector<PhotoSize>& sizes_;
  int reference_;
  std::vector<PhotoPair>& pairs_;
  std::vector<Eigen::Matrix3d> normalizers_;
  std::vector<Node> nodes_;
  int num_numbers_ = 0;
  double scale_ = kCauchy;
};

}  // namespace

std::string place_status_text(PlaceStatus status) {
  switch (status) {
    case PlaceStatus::Reference:
      return "reference";
    case PlaceStatus::Given:
      return "given";
    case PlaceStatus::Aligned:
      return "aligned";
    case PlaceStatus::Through:
      return "aligned through another";
    case PlaceStatus::Failed:
      break;
  }
  return "failed";
}

std::vector<PhotoPlace> place_photos(const std::vector<PhotoSize>& sizes, int reference,
                                     const std::vector<std::optional<Eigen::Matrix3d>>& given,
                                     std::vector<PhotoPair>& pairs, AlignModel model) {
  PhotoGraph graph(sizes, reference, given, pairs, model);
  graph.solve();
  return graph.places();
}

std::vector<bool> tied_to(int num_photos, const std::vector<int>& roots, const std::vector<PhotoPair>& pairs) {
  std::vector<bool> is_tied(static_cast<std::size_t>(num_photos), false);
  for (int root : roots) is_tied[root] = true;
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (const PhotoPair& pair : pairs) {
      const std::size_t a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
      if (!pair.is_accepted || is_tied[a] == is_tied[b]) continue;
      is_tied[a] = is_tied[b] = is_new = true;
    }
  }
  return is_tied;
}

}  // namespace patinate::capture
