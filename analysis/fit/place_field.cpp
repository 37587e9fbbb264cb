#include "analysis/fit/place_field.h"

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "libcommon/core/silent_log.h"
#include "libcommon/geometry/dense_solve.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

/// Waves along a side; parts of the cross-validation (docs/algorithms/fields.md).
constexpr int kMaxWaves = 16, kFolds = 4;
constexpr double kSameValue = 1e-9;  ///< Levels that are no farther apart at a place are one.

/// cos(pi i x) cos(pi j y) at a place.
Eigen::VectorXd basis_at(int num_waves, double x, double y) {
  Eigen::VectorXd b(num_waves * num_waves);
  for (int j = 0; j < num_waves; ++j) {
    for (int i = 0; i < num_waves; ++i)
      b[j * num_waves + i] = std::cos(std::numbers::pi * i * x) * std::cos(std::numbers::pi * j * y);
  }
  return b;
}

/// By how much each coefficient's square counts in bending().
Eigen::VectorXd bending_weights(int num_waves) {
  Eigen::VectorXd w(num_waves * num_waves);
  for (int j = 0; j < num_waves; ++j) {
    for (int i = 0; i < num_waves; ++i)
      w[j * num_waves + i] = std::pow(i * i + j * j, 2) * (i > 0 ? 0.5 : 1.0) * (j > 0 ? 0.5 : 1.0);
  }
  return w;
}

/// Where a value lies among a place's levels.
struct Between {
  std::size_t level = 0;  ///< And the next.
  double share = 0.0;
  double per_value = 0.0;  ///< d share / d value; 0 outside of the levels.
};

class PlaceColors {
 public:
  explicit PlaceColors(const FieldColors& colors) : c_(colors), n_(colors.places.size()) {}

  [[nodiscard]] std::size_t num_residuals() const { return 3 * c_.num_times; }

  [[nodiscard]] Between between(std::size_t place, double value) const {
    const std::size_t last = c_.levels.size() - 1;
    std::size_t k = 0;
    while (k + 1 < last && static_cast<double>(c_.values[k + 1][place]) <= value) ++k;
    while (k > 0 && width(place, k) < kSameValue) --k;
    while (k + 1 < last && width(place, k) < kSameValue) ++k;
    const double w = width(place, k);
    if (w < kSameValue) return {.level = k};
    const double share = (value - static_cast<double>(c_.values[k][place])) / w;
    if (share <= 0.0) return {.level = k};
    if (share >= 1.0) return {.level = k, .share = 1.0};
    return {.level = k, .share = share, .per_value = 1.0 / w};
  }

  /// Differences of a place, and what they change by with its value.
  void differences(std::size_t place, double value, double* residuals, double* slopes) const {
    const Between b = between(place, value);
    for (std::size_t t = 0; t < c_.num_times; ++t) {
      const std::size_t at = 3 * (t * n_ + place);
      for (std::size_t c = 0; c < 3; ++c) {
        const auto low = static_cast<double>(c_.levels[b.level][at + c]),
                   step = static_cast<double>(c_.levels[b.level + 1][at + c]) - low;
        residuals[3 * t + c] = low + b.share * step - static_cast<double>(c_.captured[at + c]);
        if (slopes != nullptr) slopes[3 * t + c] = step * b.per_value;
      }
    }
  }

  /// Sum of squares of a place.
  [[nodiscard]] double squares(std::size_t place, double value) const {
    std::vector<double> r(num_residuals());
    differences(place, value, r.data(), nullptr);
    double sum = 0.0;
    for (const double v : r) sum += v * v;
    return sum;
  }

  /// The level with the least of them.
  [[nodiscard]] double nearest(std::size_t place) const {
    double least = std::numeric_limits<double>::infinity(), value = 0.0;
    for (const std::vector<float>& level : c_.values) {
      const auto v = static_cast<double>(level[place]);
      if (const double s = squares(place, v); s < least) least = s, value = v;
    }
    return value;
  }

 private:
  [[nodiscard]] double width(std::size_t place, std::size_t k) const {
    return static_cast<double>(c_.values[k + 1][place]) - static_cast<double>(c_.values[k][place]);
  }

  const FieldColors& c_;
  std::size_t n_;
};

/// Differences of one place by all coefficients, weighted so that their squares add up to a mean.
class PlaceCost final : public ceres::CostFunction {
 public:
  PlaceCost(const PlaceColors& colors, std::size_t place, const Eigen::VectorXd& basis, double weight)
      : colors_(colors), place_(place), basis_(basis), weight_(weight) {
    set_num_residuals(static_cast<int>(colors.num_residuals()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(basis.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Eigen::VectorXd> c(parameters[0], basis_.size());
    std::vector<double> slopes(colors_.num_residuals());
    colors_.differences(place_, basis_.dot(c), residuals, slopes.data());
    for (std::size_t r = 0; r < slopes.size(); ++r) residuals[r] *= weight_;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    for (std::size_t r = 0; r < slopes.size(); ++r) {
      for (Eigen::Index k = 0; k < basis_.size(); ++k)
        jacobians[0][r * static_cast<std::size_t>(basis_.size()) + static_cast<std::size_t>(k)] =
            weight_ * slopes[r] * basis_[k];
    }
    return true;
  }

 private:
  const PlaceColors& colors_;
  std::size_t place_;
  const Eigen::VectorXd& basis_;
  double weight_;
};

/// sqrt(weight) of every coefficient, times it.
class BendingPenalty final : public ceres::CostFunction {
 public:
  explicit BendingPenalty(Eigen::VectorXd roots) : roots_(std::move(roots)) {
    set_num_residuals(static_cast<int>(roots_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(roots_.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (Eigen::Index k = 0; k < roots_.size(); ++k) residuals[k] = roots_[k] * parameters[0][k];
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        jacobians[0], roots_.size(), roots_.size()) = roots_.asDiagonal();
    return true;
  }

 private:
  Eigen::VectorXd roots_;
};

class FieldSearch {
 public:
  FieldSearch(const FieldColors& colors, const PlaceFieldOptions& options, const RunControl& control)
      : colors_(colors), places_(colors), options_(options), control_(control) {
    for (std::size_t i = 0; i < colors.places.size(); ++i) {
      nearest_.push_back(places_.nearest(i));
      const auto [x, y] = colors.places[i];
      basis_.push_back(basis_at(options.num_waves, x, y));
      const auto block = [&](double v) { return static_cast<int>(v * options.num_waves); };
      fold_.push_back((block(x) + 2 * block(y)) % kFolds);
    }
  }

  /// @param left_out  A fold, or -1. @param smoothness  Nothing: one number everywhere.
  [[nodiscard]] PlaceField fitted(std::optional<double> smoothness, int left_out) const {
    const int waves = smoothness ? options_.num_waves : 1;
    const Eigen::VectorXd penalty = smoothness.value_or(0.0) * bending_weights(waves);
    std::vector<Eigen::VectorXd> bases;
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < basis_.size(); ++i) {
      if (fold_[i] == left_out) continue;
      kept.push_back(i);
      bases.push_back(smoothness ? basis_[i] : Eigen::VectorXd::Ones(1));
    }
    Eigen::VectorXd c = smoothed(kept, bases, penalty);
    const double weight = 1.0 / std::sqrt(static_cast<double>(kept.size() * colors_.num_times));
    ceres::Problem problem;
    for (std::size_t k = 0; k < kept.size(); ++k)
      problem.AddResidualBlock(new PlaceCost(places_, kept[k], bases[k], weight), nullptr, c.data());
    problem.AddResidualBlock(new BendingPenalty(penalty.cwiseSqrt()), nullptr, c.data());
    const SilentLog silent;
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = options_.max_iterations;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    control_.throw_if_stopped();
    return {.num_waves = waves, .coefficients = {c.data(), c.data() + c.size()}};
  }

  /// Sum of squares over the places of a fold, or over all, and their number.
  [[nodiscard]] std::pair<double, std::size_t> squares(const PlaceField& field, int fold) const {
    std::pair<double, std::size_t> sum{0.0, 0};
    for (std::size_t i = 0; i < fold_.size(); ++i) {
      if (fold >= 0 && fold_[i] != fold) continue;
      sum.first += places_.squares(i, field.at(colors_.places[i][0], colors_.places[i][1]));
      ++sum.second;
    }
    return sum;
  }

  [[nodiscard]] double root_mean_square(double sum, std::size_t count) const {
    return std::sqrt(sum / static_cast<double>(count * colors_.num_times));
  }

  [[nodiscard]] double left_out(std::optional<double> smoothness) const {
    double sum = 0.0;
    std::size_t count = 0;
    for (int fold = 0; fold < kFolds; ++fold) {
      const std::size_t here = std::count(fold_.begin(), fold_.end(), fold);
      if (here == 0 || here == fold_.size()) continue;
      const auto [s, n] = squares(fitted(smoothness, fold), fold);
      sum += s, count += n;
    }
    return count > 0 ? root_mean_square(sum, count) : 0.0;
  }

  [[nodiscard]] double num_effective(const PlaceField& field, double smoothness) const {
    const Eigen::VectorXd penalty = smoothness * bending_weights(field.num_waves);
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(penalty.size(), penalty.size());
    std::vector<double> r(places_.num_residuals()), slopes(places_.num_residuals());
    for (std::size_t i = 0; i < basis_.size(); ++i) {
      places_.differences(i, field.at(colors_.places[i][0], colors_.places[i][1]), r.data(), slopes.data());
      double sum = 0.0;
      for (const double s : slopes) sum += s * s;
      h.selfadjointView<Eigen::Lower>().rankUpdate(basis_[i],
                                                   sum / static_cast<double>(basis_.size() * colors_.num_times));
    }
    const Eigen::MatrixXd full = h.selfadjointView<Eigen::Lower>();
    Eigen::MatrixXd bent = full;
    bent.diagonal() += penalty;
    return shortest_least_squares(bent, full).trace();
  }

 private:
  /// The nearest levels as a field, bent no more than the data are to bend it.
  [[nodiscard]] Eigen::VectorXd smoothed(const std::vector<std::size_t>& kept,
                                         const std::vector<Eigen::VectorXd>& bases,
                                         const Eigen::VectorXd& penalty) const {
    constexpr double kAsMuch =
        1e-3;  // Weight of a bending against a difference of levels, squared: little, but not none.
    const Eigen::Index size = penalty.size();
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(size);
    for (std::size_t k = 0; k < kept.size(); ++k) {
      a.selfadjointView<Eigen::Lower>().rankUpdate(bases[k]);
      b += nearest_[kept[k]] * bases[k];
    }
    const double largest = penalty.maxCoeff();
    if (largest > 0.0) {
      const Eigen::VectorXd weights = bending_weights(options_.num_waves);
      a.diagonal() += kAsMuch * static_cast<double>(kept.size()) * weights;
    }
    const Eigen::MatrixXd full = a.selfadjointView<Eigen::Lower>();
    return solve_ldlt(full, b);
  }

  const FieldColors& colors_;
  PlaceColors places_;
  const PlaceFieldOptions& options_;
  const RunControl& control_;
  std::vector<double> nearest_;
  std::vector<Eigen::VectorXd> basis_;
  std::vector<int> fold_;
};

void check(const FieldColors& c, const PlaceFieldOptions& o) {
  const std::size_t size = 3 * c.num_times * c.places.size();
  const auto has_size = [&](const std::vector<float>& v) { return v.size() == size; };
  if (size == 0 || c.levels.size() < 2 || c.values.size() != c.levels.size() || !has_size(c.captured) ||
      !std::all_of(c.levels.begin(), c.levels.end(), has_size) ||
      !std::all_of(c.values.begin(), c.values.end(), [&](const auto& v) { return v.size() == c.places.size(); }))
    throw InvalidInput("place field: places, times and at least two levels must have as many colors");
  if (o.num_waves < 1 || o.num_waves > kMaxWaves || o.max_iterations < 1 ||
      !std::all_of(o.smoothness.begin(), o.smoothness.end(), [](double s) { return s > 0.0; }))
    throw InvalidInput("place field: waves must be in [1, 16], iterations and weights of bending > 0");
}

}  // namespace

double PlaceField::at(double x, double y) const {
  const Eigen::Map<const Eigen::VectorXd> c(coefficients.data(), static_cast<Eigen::Index>(coefficients.size()));
  return basis_at(num_waves, x, y).dot(c);
}

double bending(const PlaceField& field) {
  const Eigen::VectorXd w = bending_weights(field.num_waves);
  double sum = 0.0;
  for (Eigen::Index k = 0; k < w.size(); ++k) sum += w[k] * std::pow(field.coefficients[k], 2);
  return sum;
}

FittedField fit_place_field(const FieldColors& colors, const PlaceFieldOptions& options, const RunControl& control) {
  check(colors, options);
  const FieldSearch search(colors, options, control);
  FittedField out;
  std::vector<std::optional<double>> tried{std::nullopt};
  if (options.num_waves > 1) tried.insert(tried.end(), options.smoothness.begin(), options.smoothness.end());
  for (std::size_t k = 0; k < tried.size(); ++k) {
    out.trials.push_back({.smoothness = tried[k], .left_out = search.left_out(tried[k])});
    control.report(static_cast<double>(k + 1) / static_cast<double>(tried.size() + 1));
  }
  const auto best = std::min_element(out.trials.begin(), out.trials.end(),
                                     [](const auto& a, const auto& b) { return a.left_out < b.left_out; });
  out.smoothness = best->smoothness;
  const auto misfit_of = [&](const PlaceField& field) {
    const auto [sum, count] = search.squares(field, -1);
    return search.root_mean_square(sum, count);
  };
  const PlaceField flat = search.fitted(std::nullopt, -1);
  out.flat_value = flat.coefficients.front();
  out.flat_misfit = misfit_of(flat);
  out.field = out.smoothness ? search.fitted(out.smoothness, -1) : flat;
  out.misfit = misfit_of(out.field);
  if (out.smoothness) out.num_effective = search.num_effective(out.field, *out.smoothness);
  control.report(1.0);
  return out;
}

}  // namespace patinate::analysis
