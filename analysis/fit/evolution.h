/// \file
/// The least value of a function of a few bounded numbers that is costly, noisy and has no derivative.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace patinate::analysis {

struct EvolutionOptions {
  int population = 0;       ///< Candidates a generation, >= 4; 0 = 4 + 3 ln n, at least 6 [Hansen 2016].
  double step = 0.3;        ///< Standard deviation at the start, as a share of the box; (0, 1].
  double tolerance = 1e-3;  ///< At an end when no coordinate's standard deviation is larger; > 0.
  double flatness = 0.0;    ///< Or when the values of two generations in a row differ by no more than this; >= 0.
  /// Flatness as a share of the least value; and at an end, too, when 8 + 2 n generations have improved it by less; >=
  /// 0.
  double relative_flatness = 0.0;
  std::uint64_t seed = 0;
  std::uint32_t purpose = 0;  ///< Keeps several searches with one seed apart.
};

/// CMA-ES [Hansen and Ostermeier 2001; constants of Hansen 2016, arXiv:1604.00772] in the box [0, 1]^n: candidates are
/// drawn from a normal distribution, ranked, and the better half moves and shapes the next. Only ranks matter, so noise
/// and any monotone change of the values are harmless. Bounds by reflection: the function is continued beyond the box
/// as its mirror image, so an optimum on an edge is one inside.
///
/// Ask for candidate(0) ... candidate(population() - 1) in any order, then tell() their values. Random numbers belong
/// to (seed, generation, candidate): the same values lead to the same search, whoever computes them in which order.
class Evolution {
 public:
  /// @param start  In [0, 1]^n, n in [1, 100]. @throws InvalidInput if not, or an option is out of range.
  explicit Evolution(const std::vector<double>& start, const EvolutionOptions& options = {});

  [[nodiscard]] static int population_of(std::size_t n, const EvolutionOptions& options);
  /// So many generations without a gain that counts are an end: 8 + 2 n.
  [[nodiscard]] static int patience_of(std::size_t n);
  [[nodiscard]] int population() const { return population_; }
  /// Generations told.
  [[nodiscard]] int generation() const { return generation_; }
  /// Candidate of the present generation, in [0, 1]^n.
  [[nodiscard]] std::vector<double> candidate(int k) const;
  /// @param values  One a candidate; infinity: undefined, worse than all others. @throws InvalidInput on NaN or another
  /// number of values.
  void tell(std::span<const double> values);
  /// At an end.
  [[nodiscard]] bool is_done() const { return is_done_; }
  /// Largest standard deviation of a coordinate.
  [[nodiscard]] double spread() const;

 private:
  [[nodiscard]] Eigen::VectorXd unfolded(int k) const;
  void adapt(const std::vector<Eigen::VectorXd>& best);
  [[nodiscard]] bool is_at_end(std::span<const double> values);

  EvolutionOptions options_;
  int population_ = 0;
  int generation_ = 0;
  int num_flat_ = 0;
  int last_gain_ = 0;  ///< `generation_` when the least value last fell by more than a difference that counts.
  double least_ = 0.0;
  bool is_done_ = false;
  Eigen::VectorXd center_, path_step_, path_shape_, scales_;
  Eigen::MatrixXd shape_, axes_;  ///< shape_ = axes_ scales_^2 axes_^T.
  double step_ = 0.0;
  std::vector<double> weights_;
};

}  // namespace patinate::analysis
