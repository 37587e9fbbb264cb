#include "analysis/fit/evolution.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "libcommon/core/random.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kLargestStep = 0.5;     ///< Half of the box: beyond, reflection makes it uniform anyway.
constexpr int kStaleGenerations = 8;     ///< And two for each dimension.
constexpr double kSmallestScale = 1e-9;  ///< Share of an axis, against a degenerate shape.

/// The mirror image in [0, 1].
double reflected(double x) {
  const double t = std::fmod(std::abs(x), 2.0);
  return t > 1.0 ? 2.0 - t : t;
}

/// Weights of the better half, largest first; they sum to 1.
std::vector<double> rank_weights(int population) {
  std::vector<double> weights;
  for (int i = 1; i <= population / 2; ++i) weights.push_back(std::log((population + 1) / 2.0) - std::log(i));
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& w : weights) w /= sum;
  return weights;
}

}  // namespace

int Evolution::population_of(std::size_t n, const EvolutionOptions& options) {
  if (options.population > 0) return options.population;
  return std::max(6, 4 + static_cast<int>(3.0 * std::log(static_cast<double>(n))));
}

Evolution::Evolution(const std::vector<double>& start, const EvolutionOptions& options) : options_(options) {
  if (start.empty() || start.size() > 100)
    throw InvalidInput("evolution: found " + std::to_string(start.size()) + " numbers to search for; use [1, 100]");
  for (double x : start) {
    if (!(x >= 0.0 && x <= 1.0)) throw InvalidInput("evolution: the start lies outside [0, 1]");
  }
  if (options.population != 0 && !(options.population >= 4 && options.population <= 1000))
    throw InvalidInput("evolution: the population must be 0 or in [4, 1000]");
  if (!(options.step > 0.0 && options.step <= 1.0)) throw InvalidInput("evolution: the step must be in (0, 1]");
  if (!(options.tolerance > 0.0) || !(options.flatness >= 0.0) || !(options.relative_flatness >= 0.0))
    throw InvalidInput("evolution: tolerance must be > 0, flatness >= 0");
  population_ = population_of(start.size(), options);
  weights_ = rank_weights(population_);
  center_ = Eigen::Map<const Eigen::VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
  const Eigen::Index n = center_.size();
  path_step_ = path_shape_ = Eigen::VectorXd::Zero(n);
  shape_ = axes_ = Eigen::MatrixXd::Identity(n, n);
  scales_ = Eigen::VectorXd::Ones(n);
  step_ = std::min(options_.step, kLargestStep);
  least_ = std::numeric_limits<double>::infinity();
}

Eigen::VectorXd Evolution::unfolded(int k) const {
  RandomStream random(options_.seed, static_cast<std::uint64_t>(generation_) * 4096 + static_cast<std::uint64_t>(k),
                      options_.purpose);
  Eigen::VectorXd z(center_.size());
  for (double& x : z) x = random.normal();
  return center_ + step_ * (axes_ * scales_.cwiseProduct(z));
}

std::vector<double> Evolution::candidate(int k) const {
  const Eigen::VectorXd x = unfolded(k);
  std::vector<double> out;
  for (double v : x) out.push_back(reflected(v));
  return out;
}

double Evolution::spread() const { return step_ * std::sqrt(shape_.diagonal().maxCoeff()); }

void Evolution::tell(std::span<const double> values) {
  if (values.size() != static_cast<std::size_t>(population_))
    throw InvalidInput("evolution: found " + std::to_string(values.size()) + " values for " +
                       std::to_string(population_) + " candidates");
  for (double v : values) {
    if (std::isnan(v)) throw InvalidInput("evolution: a value is NaN");
  }
  if (is_done_) return;
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  std::vector<Eigen::VectorXd> best;
  for (std::size_t i = 0; i < weights_.size(); ++i) best.push_back(unfolded(order[i]));
  adapt(best);
  ++generation_;
  is_done_ = is_at_end(values);
}

void Evolution::adapt(const std::vector<Eigen::VectorXd>& best) {
  const auto n = static_cast<double>(center_.size());
  double squares = 0.0;
  for (double w : weights_) squares += w * w;
  const double mu = 1.0 / squares;
  const double c_step = (mu + 2.0) / (n + mu + 5.0);
  const double damping = 1.0 + 2.0 * std::max(0.0, std::sqrt((mu - 1.0) / (n + 1.0)) - 1.0) + c_step;
  const double c_path = (4.0 + mu / n) / (n + 4.0 + 2.0 * mu / n);
  const double c_one = 2.0 / ((n + 1.3) * (n + 1.3) + mu);
  const double c_mu = std::min(1.0 - c_one, 2.0 * (mu - 2.0 + 1.0 / mu) / ((n + 2.0) * (n + 2.0) + mu));
  const double expected_length = std::sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));

  Eigen::VectorXd moved = Eigen::VectorXd::Zero(center_.size());
  Eigen::MatrixXd rank_mu = Eigen::MatrixXd::Zero(center_.size(), center_.size());
  for (std::size_t i = 0; i < best.size(); ++i) {
    const Eigen::VectorXd y = (best[i] - center_) / step_;
    moved += weights_[i] * y;
    rank_mu += weights_[i] * y * y.transpose();
  }
  center_ += step_ * moved;
  const Eigen::VectorXd whitened = axes_ * scales_.cwiseInverse().cwiseProduct(axes_.transpose() * moved);
  path_step_ = (1.0 - c_step) * path_step_ + std::sqrt(c_step * (2.0 - c_step) * mu) * whitened;
  const double length = path_step_.norm();
  const bool is_steady = length / std::sqrt(1.0 - std::pow(1.0 - c_step, 2.0 * (generation_ + 1))) <
                         (1.4 + 2.0 / (n + 1.0)) * expected_length;
  path_shape_ = (1.0 - c_path) * path_shape_;
  if (is_steady) path_shape_ += std::sqrt(c_path * (2.0 - c_path) * mu) * moved;
  const double kept = 1.0 - c_one - c_mu + (is_steady ? 0.0 : c_one * c_path * (2.0 - c_path));
  shape_ = kept * shape_ + c_one * path_shape_ * path_shape_.transpose() + c_mu * rank_mu;
  step_ = std::min(step_ * std::exp(std::min(1.0, c_step / damping * (length / expected_length - 1.0))), kLargestStep);

  shape_ = 0.5 * (shape_ + shape_.transpose()).eval();
  const SymmetricEigen<Eigen::MatrixXd> eigen = symmetric_eigen(shape_);
  axes_ = eigen.vectors;
  scales_ = eigen.values.cwiseMax(kSmallestScale * kSmallestScale).cwiseSqrt();
}

int Evolution::patience_of(std::size_t n) { return kStaleGenerations + 2 * static_cast<int>(n); }

bool Evolution::is_at_end(std::span<const double> values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double counts = std::max(options_.flatness, options_.relative_flatness * std::abs(*low));
  num_flat_ = std::isfinite(*high) && *high - *low <= counts ? num_flat_ + 1 : 0;
  if (*low < least_ - counts) {
    least_ = *low;
    last_gain_ = generation_;
  }
  const bool is_stale = options_.relative_flatness > 0.0 && std::isfinite(least_) &&
                        generation_ - last_gain_ >= patience_of(static_cast<std::size_t>(center_.size()));
  return spread() <= options_.tolerance || num_flat_ >= 2 || is_stale;
}

}  // namespace patinate::analysis
