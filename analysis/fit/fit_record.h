/// \file
/// What was tried and what came of it, as data and as files.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/fit/fit_objective.h"
#include "analysis/fit/fit_parameter.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

/// One set of values and how far the surface was.
struct FitPoint {
  std::vector<double> values;  ///< Values of all parameters, in order.
  ObjectiveValue result;
  std::vector<std::optional<double>> captures = {};  ///< Objective of each; none where there is one.
};

/// One aging and the appearances tried for it: at least one, all with the same values of what needs aging.
struct FitEvaluation {
  std::string name;
  std::vector<FitPoint> points;
  std::optional<double> chance = {};    ///< The objective of the first point against itself, with another seed.
  std::optional<double> held_out = {};  ///< Objective of the first point, on frames that no search sees.
  bool is_converged = false;            ///< The search for an appearance came to its end.
  bool is_skipped = false;              ///< The search had come to its end before; there are no points then.

  /// The least objective, the first of equal ones; nothing when all are undefined.
  [[nodiscard]] std::optional<std::size_t> best() const;
};

[[nodiscard]] Json evaluation_json(const FitEvaluation& evaluation);
/// @param num_parameters, num_terms  What it must have. @throws IoError
[[nodiscard]] FitEvaluation read_evaluation(const std::filesystem::path& file, std::size_t num_parameters,
                                            std::size_t num_terms);

/// A header and a line a point: evaluation, appearance, every parameter, objective, that of every capture where there
/// are several, every figure, problem. Undefined ones are empty.
/// @param parameters, captures  Their names; of one capture none.
[[nodiscard]] std::string evaluations_csv(std::span<const FitEvaluation> evaluations,
                                          std::span<const std::string> parameters,
                                          std::span<const std::string> captures, std::span<const FitTerm> terms);

}  // namespace patinate::analysis
