/// \file
/// A number that differs smoothly from place to place: a few low cosines over a surface's square, and how they are
/// found.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// f(x, y) = sum over i, j < num_waves of c_ij cos(pi i x) cos(pi j y); x and y in [0, 1] from the upper left corner.
/// Cosines have no slope at the square's sides, so that nothing there is set by what is not on the surface.
struct PlaceField {
  int num_waves = 1;                         ///< Along a side, [1, 16]; 1: one number everywhere.
  std::vector<double> coefficients = {0.0};  ///< num_waves^2: c_ij at j * num_waves + i.

  [[nodiscard]] double at(double x, double y) const;
};

/// Mean over the square of (d2f/dx2 + d2f/dy2)^2, over pi^4: the energy of a thin plate bent like f, exactly
/// sum (i^2 + j^2)^2 c_ij^2 n_i n_j with n_0 = 1, else 1/2.
[[nodiscard]] double bending(const PlaceField& field);

/// Colors of places over time, as they were captured and as a model has them with several values of one number. What
/// happens at a place is to depend on the value there alone: then colors of a model whose number differs from place to
/// place can be read from those of models in which it does not.
struct FieldColors {
  std::vector<std::array<double, 2>> places;  ///< N: x and y in [0, 1].
  std::size_t num_times = 0;
  std::vector<float> captured;             ///< [time][place][3], CIELAB.
  std::vector<std::vector<float>> levels;  ///< Colors of the model, one a level; at least 2.
  std::vector<std::vector<float>> values;  ///< [level][place]: the number's, never falling from level to level.
};

struct PlaceFieldOptions {
  int num_waves = 6;  ///< Number of waves of PlaceField, [1, 16].
  /// Weights of bending that are tried, Delta E^2, each > 0. The one is taken with which blocks of the surface that the
  /// search leaves out come nearest, and none (one number everywhere) where that is nearer still.
  std::vector<double> smoothness{1000.0, 100.0, 10.0, 1.0, 0.1};
  int max_iterations = 30;  ///< > 0.
};

/// Effect of one weight of bending.
struct SmoothnessTrial {
  std::optional<double> smoothness = {};  ///< Nothing: one number everywhere.
  double left_out =
      0.0;  ///< Root mean square Delta E 1976 of the blocks left out in turn, each by a field of the others.
};

struct FittedField {
  PlaceField field;
  std::optional<double> smoothness = {};  ///< Taken; nothing: one number everywhere.
  std::vector<SmoothnessTrial> trials;    ///< One number everywhere first, then the weights as given.
  double misfit = 0.0;       ///< Root mean square Delta E 1976 over places and times, as the levels foretell it.
  double flat_misfit = 0.0;  ///< Misfit of the best single number.
  double flat_value = 0.0;   ///< That number.
  double num_effective =
      1.0;  ///< Numbers that the data decide: the trace of (H + penalty)^-1 H [Hastie and Tibshirani 1990].
};

/// Minimizes the mean over places and times of |captured - model|^2 + smoothness x bending() (Ceres), colors between
/// levels read along straight lines; outside of them those of the ends. It begins at each place's nearest level,
/// smoothed. Blocks are squares of half the shortest wave, a fourth of them left out at a time, so that each lies among
/// blocks that stay.
/// @throws InvalidInput if lists differ in length, there are fewer than two levels or no places, or an option is out of
/// range; Canceled. Same bits for any number of threads.
[[nodiscard]] FittedField fit_place_field(const FieldColors& colors, const PlaceFieldOptions& options,
                                          const RunControl& control = {});

}  // namespace patinate::analysis
