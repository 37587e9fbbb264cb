/// \file
/// Noise of a given size in space: what differs from place to place for no reason that the shape knows of.
#pragma once

#include <cstdint>
#include <span>

#include "patinate/core/options.h"
#include "patinate/geometry/mesh.h"

namespace patinate {

/// Settings of noise_at().
struct NoiseOptions {
  double wavelength_mm = 20.0;  ///< Of the coarsest octave; > 0.
  int octaves = 3;              ///< Each half as long and half as strong as the one before; [1, 8].
  std::int64_t seed = 1;        ///< >= 0.
};
void describe(OptionVisitor& visitor, NoiseOptions& options);

/// Gradient noise on a hashed lattice [Perlin 2002, "Improving noise"], turned so that no usual plane lies along it, an
/// octave's lattice elsewhere than the one's before. Mean 0.5, standard deviation 0.2, clamped to [0, 1] (under 1 % of
/// all places). Of one octave: along a straight line it rises through 0.5 once a wavelength in the mean, and nothing in
/// it is much finer than half of that.
/// The same bits on every machine: sums and products only.
/// @param position_mm  Within 1e9. @param least_mm  Octaves shorter than this are left out, and fade from twice of it:
/// 0 = none.
[[nodiscard]] double noise_at(const Vec3& position_mm, const NoiseOptions& options, double least_mm = 0.0);
/// The same at many places, several times as fast. @param values  As many as positions.
void noise_at(std::span<const Vec3> positions_mm, const NoiseOptions& options, double least_mm,
              std::span<double> values);

}  // namespace patinate
