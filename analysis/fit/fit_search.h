/// \file
/// Trying values: one aging, and for it the best of the parameters that need none.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/fit/fit_record.h"

namespace patinate::analysis {

/// A model and what it is compared with: one capture, or several of which the objective is the mean.
struct FitModel {
  struct Capture {
    std::string name;
    AgeWith age;
    const FitObjective* objective = nullptr;
    const FitObjective* held_out = nullptr;  ///< Objective of frames that no search sees; may be null.
  };
  std::vector<FitParameter> parameters;
  std::vector<Capture> captures;                   ///< At least one.
  int repeats = 1;                                 ///< Seeds over which an objective is averaged; >= 1.
  double flatness = 0.0, relative_flatness = 0.0;  ///< When a search is at its end: EvolutionOptions.
  double tolerance = 1e-3;
  std::uint64_t seed = 0;

  /// Indices of the parameters that need aging, or that need none.
  [[nodiscard]] std::vector<std::size_t> indices(bool is_appearance) const;
  /// Those of all values that a capture's model takes.
  [[nodiscard]] std::vector<double> values_of(std::size_t capture, const std::vector<double>& all) const;
};

/// How the parameters that need no aging are searched.
struct AppearanceSearch {
  int num_appearance = 1;  ///< At most; 1: only the given values.
  double step = 0.3;       ///< Step as EvolutionOptions.
  int starts = 1;          ///< Starts as MultiStartOptions.
  std::uint64_t item = 0;  ///< Its random numbers.
};

/// Ages once a seed with `values`, composes with them, and then searches for better values of the parameters that need
/// no aging: the objective is then a function of the others alone [variable projection, Golub and Pereyra 1973].
/// @returns points of which the first has `values`. Values that the model does not take together give one undefined
/// point.
/// @param seed_shift  The first of the seeds.
[[nodiscard]] FitEvaluation evaluate(const FitModel& model, const std::string& name, const std::vector<double>& values,
                                     const AppearanceSearch& search, std::uint64_t seed_shift,
                                     const RunControl& control = {});

/// Composes with each of several sets of values, which differ from the first only in parameters that need no aging.
[[nodiscard]] FitEvaluation evaluate_appearances(const FitModel& model, const std::string& name,
                                                 std::span<const std::vector<double>> values, std::uint64_t seed_shift,
                                                 const RunControl& control = {});

/// Objective by chance at `values`: a surface with another seed takes the captured one's place.
/// @returns that surface against the real capture as the one point, and `chance`: of the seeds that a search uses,
/// against that surface.
/// @param draw  Number of the other seed, >= 1.
[[nodiscard]] FitEvaluation draw_chance(const FitModel& model, const std::string& name,
                                        const std::vector<double>& values, std::uint64_t draw,
                                        const RunControl& control = {});

}  // namespace patinate::analysis
