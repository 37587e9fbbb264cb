/// \file
/// A search from several starts: what a single descent finds is the valley that it began in.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "analysis/fit/evolution.h"

namespace patinate::analysis {

struct MultiStartOptions {
  EvolutionOptions search = {};
  /// Valleys that are followed at most, in n dimensions no more than 2 n; [1, 100]. 1: from the given start alone,
  /// without a design.
  int starts = 4;
};

/// First a Latin hypercube over the box, of 1 to 6 generations; then an Evolution from each of the best of its points
/// and the start, no two of them near each other. They share the generations: the next belongs to the one that has had
/// fewest of them times 2^rank, so that the best gets half and none is forgotten. One that comes to where a better one
/// has ended is given up.
///
/// Asked and told like an Evolution. What is asked does not depend on the budget: a larger one continues a smaller one.
class MultiStart {
 public:
  /// @param start  In [0, 1]^n. @param start_value  Infinity: undefined. @throws InvalidInput as Evolution does, and
  /// for a number of starts out of range.
  MultiStart(const std::vector<double>& start, double start_value, const MultiStartOptions& options = {});

  [[nodiscard]] int population() const { return population_; }
  /// Generations told.
  [[nodiscard]] int generation() const { return generation_; }
  /// Candidate of the present generation, in [0, 1]^n.
  [[nodiscard]] std::vector<double> candidate(int k) const;
  /// @param values  One a candidate; infinity: undefined. @throws InvalidInput on NaN or another number of values.
  void tell(std::span<const double> values);
  /// Every descent has come to an end.
  [[nodiscard]] bool is_done() const { return is_done_; }
  /// The descent that found the least value has come to an end.
  [[nodiscard]] bool is_converged() const;
  /// Largest standard deviation of a coordinate of the present generation; of the design: the first step.
  [[nodiscard]] double spread() const;
  /// Where candidate k comes from: 0 the start, i the i-th point of the design, counted from 1.
  [[nodiscard]] std::size_t origin(int k) const;

  /// State of a start's descent.
  struct Descent {
    std::size_t origin = 0;
    std::vector<double> at;  ///< The best that it found.
    double value = std::numeric_limits<double>::infinity();
    int generations = 0;
    bool is_converged = false;
    bool is_given_up = false;  ///< It came to where a better one had ended.
    /// By how much its last Evolution::patience_of() generations brought its value down; infinity as long as it has had
    /// no more than these.
    double lately_gained = std::numeric_limits<double>::infinity();
  };
  /// Best first; none as long as there is a design to look at.
  [[nodiscard]] std::vector<Descent> descents() const;
  /// Descent::lately_gained of the one that found the least value; infinity where that is a point that none began at.
  [[nodiscard]] double lately_gained() const;

 private:
  struct Chain {
    Evolution search;
    Descent found;
    std::vector<double> values = {};  ///< The least before each of its generations.
  };
  [[nodiscard]] bool is_design() const { return chains_.empty(); }
  [[nodiscard]] std::size_t design_index(int k) const;
  void choose_starts();
  void begin(std::size_t origin, double step);
  void choose_next();
  [[nodiscard]] double least_value() const;

  MultiStartOptions options_;
  int population_ = 0, generation_ = 0;
  bool is_done_ = false;
  std::vector<std::vector<double>> points_;  ///< The start, and those of the design.
  std::vector<double> values_;
  std::vector<Chain> chains_;
  std::size_t current_ = 0;
};

/// Result of a search.
struct Minimum {
  std::vector<double> at;
  double value = 0.0;
  int num_evaluations = 0;
  bool is_converged = false;  ///< An end was reached within the budget.
};
/// Calls `f` at most `budget` times, whole generations, `start` first.
[[nodiscard]] Minimum minimize(const std::function<double(const std::vector<double>&)>& f,
                               const std::vector<double>& start, int budget, const MultiStartOptions& options = {});

}  // namespace patinate::analysis
