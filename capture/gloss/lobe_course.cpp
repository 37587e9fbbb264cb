#include "capture/gloss/lobe_course.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace patinate::capture {

namespace {

/// Range of roughness that the course may have.
constexpr double kFirstRoughness = 0.1, kLastRoughness = 0.95;
constexpr double kChange = 1.0;  ///< Change of a logarithm over all of the time.
// Lobe where nothing tells: satin of a mineral, once for the whole course.
constexpr double kUsualRoughness = 0.5, kUsualStrength = 0.04, kUsualSpread = 1.0;
constexpr int kBlock = 4;                                  ///< Tiles along a block whose rests are looked at together.
constexpr double kMinStrength = 1e-4, kMaxStrength = 3.0;  ///< Range of a lobe's strength.
constexpr double kSignificant = 30.0;  ///< Chi-square, 5.5 standard deviations: as among relit materials.
constexpr int kMinTiles = 8;           ///< Least tiles of a photograph that counts.
/// Rounds of course and noise, and Gauss-Newton steps of each.
constexpr int kCourseRounds = 5, kMostSteps = 30;
constexpr double kNearFrames = 3.0;  ///< Photographs within which a tile keeps its albedo, under a lamp that moves.
const double kNodeStep = std::log(kLastRoughness / kFirstRoughness) / (kNumLobeNodes - 1);

using Pair = Eigen::Vector2d;

/// Logarithms of roughness and strength.
struct State {
  double roughness, strength;
};

class CourseFit {
 public:
  CourseFit(const std::vector<TileSamples>& frames, const std::vector<double>& times, int columns, bool is_moving)
      : frames_(frames), times_(times), columns_(columns), is_moving_(is_moving), state_(frames.size()) {
    for (const TileSamples& f : frames) {
      const auto n = f.value.rows();
      weight_.emplace_back(Eigen::VectorXd::Ones(n));
      own_.emplace_back(Eigen::VectorXd::Zero(n));
      rest_.emplace_back(Eigen::VectorXd::Zero(n));
    }
  }

  LobeCourse solve() {
    LobeCourse course;
    course.at.resize(frames_.size());
    if (!has_any()) return course;
    start();
    find_rests();
    measure_noise();
    for (int round = 0; round < kCourseRounds; ++round) {
      if (round > 0) weigh();
      descend();
      find_rests();
      measure_noise();
      if (is_moving_ && round + 1 < kCourseRounds) give_tiles_their_albedo();
    }
    weigh();
    tell(course);
    return course;
  }

 private:
  [[nodiscard]] bool counts(std::size_t t) const { return frames_[t].value.rows() >= kMinTiles; }
  [[nodiscard]] bool has_any() const {
    for (std::size_t t = 0; t < frames_.size(); ++t)
      if (counts(t)) return true;
    return false;
  }

  /// Lobes at any roughness, and their slope by its logarithm: cubic between nodes [Catmull and Rom 1974].
  void lobes(std::size_t t, double log_roughness, Eigen::VectorXd& lobe, Eigen::VectorXd& slope) const {
    const double at = std::clamp((log_roughness - std::log(kFirstRoughness)) / kNodeStep, 0.0, kNumLobeNodes - 1.0);
    const int i = std::min(static_cast<int>(at), kNumLobeNodes - 2);
    const double u = at - i;
    const auto& table = frames_[t].log_lobe;
    const auto node = [&](int k) { return table.col(std::clamp(k, 0, kNumLobeNodes - 1)); };
    const double a = u * (u * (1.0 - 0.5 * u) - 0.5), b = 1.0 + u * u * (1.5 * u - 2.5),
                 c = u * (0.5 + u * (2.0 - 1.5 * u)), d = 0.5 * u * u * (u - 1.0);
    const double da = -0.5 + u * (2.0 - 1.5 * u), db = u * (4.5 * u - 5.0), dc = 0.5 + u * (4.0 - 4.5 * u),
                 dd = u * (1.5 * u - 1.0);
    lobe = (a * node(i - 1) + b * node(i) + c * node(i + 1) + d * node(i + 2)).array().exp();
    slope = lobe.cwiseProduct(da * node(i - 1) + db * node(i) + dc * node(i + 1) + dd * node(i + 2)) / kNodeStep;
  }
  [[nodiscard]] Eigen::VectorXd values(std::size_t t) const { return frames_[t].value.rowwise().mean() - own_[t]; }
  /// Less the weighted mean, with which the albedo is eliminated.
  [[nodiscard]] Eigen::VectorXd centered(std::size_t t, const Eigen::VectorXd& v) const {
    return v.array() - weight_[t].dot(v) / weight_[t].sum();
  }

  /// One photograph's normal equations at a state. @returns its chi-square.
  double equations(std::size_t t, const State& s, Eigen::Matrix2d& matrix, Pair& right) const {
    matrix.setZero();
    right.setZero();
    if (!counts(t)) return 0.0;
    Eigen::VectorXd lobe, slope;
    lobes(t, s.roughness, lobe, slope);
    const double strength = std::exp(s.strength);
    const Eigen::VectorXd shape = strength * centered(t, lobe), turn = strength * centered(t, slope),
                          off = centered(t, values(t)) - shape;
    const auto w = weight_[t].array();
    matrix(0, 0) = (w * turn.array().square()).sum();
    matrix(0, 1) = matrix(1, 0) = (w * turn.array() * shape.array()).sum();
    matrix(1, 1) = (w * shape.array().square()).sum();
    right = {(w * turn.array() * off.array()).sum(), (w * shape.array() * off.array()).sum()};
    return (w * off.array().square()).sum();
  }

  /// The strength that is best with a roughness, and what it saves of chi-square.
  [[nodiscard]] std::array<double, 2> best_strength(std::size_t t, double log_roughness) const {
    Eigen::VectorXd lobe, slope;
    lobes(t, log_roughness, lobe, slope);
    const Eigen::VectorXd shape = centered(t, lobe);
    const double square = (weight_[t].array() * shape.array().square()).sum(),
                 product = (weight_[t].array() * shape.array() * centered(t, values(t)).array()).sum();
    if (!(square > 0.0) || !(product > 0.0)) return {kMinStrength, 0.0};
    return {std::clamp(product / square, kMinStrength, kMaxStrength), product * product / square};
  }

  /// Begins with the course over the nodes that saves most, less what the prior asks for its steps [Viterbi 1967].
  void start() {
    const std::size_t num = frames_.size();
    std::vector<std::array<double, kNumLobeNodes>> sum(num);
    std::vector<std::array<int, kNumLobeNodes>> from(num);
    for (std::size_t t = 0; t < num; ++t) {
      const double noise =
          counts(t) ? centered(t, values(t)).squaredNorm() / static_cast<double>(frames_[t].value.rows()) : 1.0;
      for (int k = 0; k < kNumLobeNodes; ++k) {
        const auto at = static_cast<std::size_t>(k);
        double best = 0.0;
        from[t][at] = k;
        if (t > 0) {
          best = -1e300;
          for (int j = 0; j < kNumLobeNodes; ++j) {
            const double step = (k - j) * kNodeStep, score = sum[t - 1][j] - step * step / step_variance(t - 1);
            if (score > best) best = score, from[t][at] = j;
          }
        }
        const double saved = counts(t) ? best_strength(t, std::log(lobe_node_roughness(k)))[1] : 0.0;
        sum[t][at] = best + saved / std::max(noise, 1e-12);
      }
    }
    int k = static_cast<int>(std::max_element(sum.back().begin(), sum.back().end()) - sum.back().begin());
    double last_strength = std::log(kMinStrength);
    for (std::size_t t = num; t-- > 0;) {
      state_[t].roughness = std::log(lobe_node_roughness(k));
      if (counts(t)) last_strength = std::log(best_strength(t, state_[t].roughness)[0]);
      state_[t].strength = last_strength;
      k = from[t][k];
    }
  }

  [[nodiscard]] double step_variance(std::size_t t) const {
    const double span = times_.back() - times_.front();
    return kChange * kChange * (span > 0.0 ? (times_[t + 1] - times_[t]) / span : 1.0);
  }

  /// Cost of all photographs and the prior, and the equations of a step.
  double system(const std::vector<State>& state, Eigen::SparseMatrix<double>& matrix, Eigen::VectorXd& right) const {
    const auto num = static_cast<Eigen::Index>(state.size());
    const double usual = 1.0 / (kUsualSpread * kUsualSpread * static_cast<double>(num));
    std::vector<Eigen::Triplet<double>> entries;
    right = Eigen::VectorXd::Zero(2 * num);
    double cost = 0.0;
    for (Eigen::Index t = 0; t < num; ++t) {
      const auto at = static_cast<std::size_t>(t);
      Eigen::Matrix2d m;
      Pair r;
      cost += equations(at, state[at], m, r) / noise_;
      const Pair from_usual(std::log(kUsualRoughness) - state[at].roughness,
                            std::log(kUsualStrength) - state[at].strength);
      cost += usual * from_usual.squaredNorm();
      right.segment<2>(2 * t) += r / noise_ + usual * from_usual;
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j)
          entries.emplace_back(2 * t + i, 2 * t + j, m(i, j) / noise_ + (i == j ? usual : 0.0));
      if (t + 1 == num) continue;
      const double precision = 1.0 / step_variance(at);
      const Pair step(state[at + 1].roughness - state[at].roughness, state[at + 1].strength - state[at].strength);
      cost += precision * step.squaredNorm();
      for (int i = 0; i < 2; ++i) {
        right[2 * t + i] += precision * step[i];
        right[2 * t + 2 + i] -= precision * step[i];
        entries.emplace_back(2 * t + i, 2 * t + i, precision);
        entries.emplace_back(2 * t + 2 + i, 2 * t + 2 + i, precision);
        entries.emplace_back(2 * t + i, 2 * t + 2 + i, -precision);
        entries.emplace_back(2 * t + 2 + i, 2 * t + i, -precision);
      }
    }
    matrix.resize(2 * num, 2 * num);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return cost;
  }

  /// Gauss-Newton steps, damped where they do not go downhill [Levenberg 1944].
  void descend() {
    Eigen::SparseMatrix<double> matrix, next_matrix;
    Eigen::VectorXd right, next_right;
    double cost = system(state_, matrix, right), damping = 1e-4;
    for (int step = 0; step < kMostSteps; ++step) {
      Eigen::SparseMatrix<double> damped = matrix;
      for (Eigen::Index i = 0; i < damped.rows(); ++i) damped.coeffRef(i, i) *= 1.0 + damping;
      const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(damped);
      const Eigen::VectorXd change = solver.solve(right);
      if (solver.info() != Eigen::Success || !change.allFinite()) return;
      std::vector<State> next = state_;
      for (std::size_t t = 0; t < next.size(); ++t) {
        const auto i = static_cast<Eigen::Index>(2 * t);
        next[t].roughness = std::clamp(next[t].roughness + std::clamp(change[i], -0.5, 0.5), std::log(kFirstRoughness),
                                       std::log(kLastRoughness));
        next[t].strength = std::clamp(next[t].strength + std::clamp(change[i + 1], -1.0, 1.0), std::log(kMinStrength),
                                      std::log(kMaxStrength));
      }
      const double next_cost = system(next, next_matrix, next_right);
      if (!(next_cost < cost)) {
        damping *= 10.0;
        if (damping > 1e6) return;
        continue;
      }
      const bool is_settled = cost - next_cost < 1e-6 * (1.0 + cost);
      state_ = std::move(next);
      matrix.swap(next_matrix);
      right.swap(next_right);
      cost = next_cost;
      damping = std::max(1e-8, 0.2 * damping);
      if (is_settled) return;
    }
  }

  /// Tiles are less certain by the share of their highlight that its form is off.
  void weigh() {
    Eigen::VectorXd lobe, slope;
    for (std::size_t t = 0; t < frames_.size(); ++t) {
      if (!counts(t)) continue;
      lobes(t, state_[t].roughness, lobe, slope);
      const double off = kFormOff * std::exp(state_[t].strength);
      weight_[t] = (1.0 + (off * lobe).array().square() / variance_).inverse();
    }
  }

  void find_rests() {
    Eigen::VectorXd lobe, slope;
    for (std::size_t t = 0; t < frames_.size(); ++t) {
      if (!counts(t)) continue;
      lobes(t, state_[t].roughness, lobe, slope);
      rest_[t] = centered(t, values(t) - std::exp(state_[t].strength) * lobe);
    }
  }

  /// Noise of a tile, and how much less neighboring tiles tell together than independent ones.
  void measure_noise() {
    double num_frames = 0.0, squares = 0.0, count = 0.0, blocks = 0.0, block_count = 0.0, products = 0.0, pairs = 0.0;
    for (std::size_t t = 0; t < frames_.size(); ++t) {
      if (!counts(t)) continue;
      num_frames += 1.0;
      std::map<int, std::pair<double, int>> of_block;
      std::map<int, double> now;
      for (Eigen::Index i = 0; i < rest_[t].size(); ++i) {
        const double r = rest_[t][i] * std::sqrt(weight_[t][i]);
        squares += r * r;
        count += 1.0;
        const int tile = frames_[t].tile[i], x = tile % columns_, y = tile / columns_;
        auto& [sum, number] = of_block[y / kBlock * columns_ + x / kBlock];
        sum += r;
        ++number;
        now[tile] = r;
      }
      for (const auto& [block, s] : of_block) {
        if (2 * s.second < kBlock * kBlock) continue;
        blocks += s.first * s.first / s.second;
        block_count += 1.0;
      }
      for (const auto& [tile, r] : now) {
        const auto before = last_.find(tile);
        if (before == last_.end()) continue;
        products += r * before->second;
        pairs += 0.5 * (r * r + before->second * before->second);
      }
      last_ = std::move(now);
    }
    last_.clear();
    variance_ = std::max(1e-10, squares / std::max(1.0, count));
    const double alike = block_count > 0.0 ? blocks / block_count / variance_ : 1.0;
    const double persistence = pairs > 0.0 && !is_moving_ ? std::clamp(products / pairs, 0.0, 1.0) : 0.0;
    noise_ = variance_ * std::clamp(alike, 1.0, 1.0 * kBlock * kBlock) * (1.0 + persistence * (num_frames - 1.0));
  }

  /// The mean of a tile's rests over the photographs near in time, as far as they are more than noise.
  void give_tiles_their_albedo() {
    const std::size_t num = frames_.size();
    std::map<int, std::vector<std::pair<std::size_t, double>>> of_tile;
    for (std::size_t t = 0; t < num; ++t) {
      for (Eigen::Index i = 0; counts(t) && i < rest_[t].size(); ++i)
        of_tile[frames_[t].tile[i]].emplace_back(t, rest_[t][i] + own_[t][i]);
    }
    for (std::size_t t = 0; t < num; ++t) {
      for (Eigen::Index i = 0; counts(t) && i < rest_[t].size(); ++i) {
        double sum = 0.0, norm = 1.0;  // Shrinkage: one pseudo-observation of 0.
        for (const auto& [other, rest] : of_tile[frames_[t].tile[i]]) {
          const double far = (static_cast<double>(other) - static_cast<double>(t)) / kNearFrames;
          const double near = std::exp(-0.5 * far * far);
          sum += near * rest;
          norm += near;
        }
        own_[t][i] = sum / norm;
      }
    }
  }

  void tell(LobeCourse& course) {
    Eigen::SparseMatrix<double> matrix;
    Eigen::VectorXd right;
    system(state_, matrix, right);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    double saved = 0.0;
    Eigen::Vector3d by_channel = Eigen::Vector3d::Zero();
    Eigen::VectorXd lobe, slope;
    for (std::size_t t = 0; t < frames_.size(); ++t) {
      LobeAt& at = course.at[t];
      at.roughness = std::exp(state_[t].roughness);
      at.strength = std::exp(state_[t].strength);
      Eigen::Matrix2d alone;
      Pair unused;
      const double with = equations(t, state_[t], alone, unused);
      for (int i = 0; i < 2; ++i) {
        const auto row = static_cast<Eigen::Index>(2 * t) + i;
        const double variance = solver.solve(Eigen::VectorXd::Unit(matrix.rows(), row))[row];
        (i == 0 ? at.roughness_deviation : at.strength_deviation) = std::sqrt(std::max(0.0, variance));
      }
      if (!counts(t)) continue;
      saved += ((weight_[t].array() * centered(t, values(t)).array().square()).sum() - with) / noise_;
      lobes(t, state_[t].roughness, lobe, slope);
      const Eigen::VectorXd weighted = weight_[t].cwiseProduct(centered(t, lobe));
      for (int c = 0; c < 3; ++c) by_channel[c] += at.strength * weighted.dot(frames_[t].value.col(c));
    }
    course.saved = saved;
    course.is_told = course.saved > kSignificant;
    by_channel = by_channel.cwiseMax(0.0);
    if (by_channel.sum() > 0.0) course.tint = by_channel / by_channel.mean();
  }

  const std::vector<TileSamples>& frames_;
  const std::vector<double>& times_;
  int columns_;
  bool is_moving_;
  std::vector<State> state_;
  std::vector<Eigen::VectorXd> weight_;  ///< [0, 1], of each tile.
  std::vector<Eigen::VectorXd> own_;     ///< Excess of a tile's albedo over the material's.
  std::vector<Eigen::VectorXd> rest_;
  std::map<int, double> last_;
  double variance_ = 1e-4;  ///< Variance of a tile.
  double noise_ = 1e-4;     ///< By which chi-square counts: tiles and photographs that tell the same count once.
};

}  // namespace

double lobe_node_roughness(int node) { return kFirstRoughness * std::exp(node * kNodeStep); }

LobeCourse fit_lobe_course(const std::vector<TileSamples>& frames, const std::vector<double>& times, int columns,
                           bool is_moving) {
  return CourseFit(frames, times, columns, is_moving).solve();
}

}  // namespace patinate::capture
