#include "patinate/controls/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace patinate {

namespace {

/// Lattice steps in a wavelength: noise on a lattice of step 1 rises through its mean 0.422 times a step (measured over
/// 2,000,000 steps in four directions).
constexpr double kStepsPerWavelength = 2.37;
constexpr double kDeviation = 0.27;  ///< Of noise on such a lattice, measured with it.
constexpr double kWantedDeviation = 0.2;

/// A turn by the quaternion (2, 3, -1, 5) / sqrt(39): no axis, diagonal or level plane lies along the lattice.
constexpr std::array<std::array<double, 3>, 3> kTurn{{{-13.0 / 39.0, -26.0 / 39.0, 26.0 / 39.0},
                                                      {14.0 / 39.0, -29.0 / 39.0, -22.0 / 39.0},
                                                      {34.0 / 39.0, 2.0 / 39.0, 19.0 / 39.0}}};

/// All bits of the result depend on all bits of x [Steele, Lea, Flood 2014, SplitMix].
constexpr std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

/// One of twelve directions to the middles of a cube's edges, chosen by a hash, times d.
double slope_along(std::uint64_t hash, double x, double y, double z) {
  const auto edge = static_cast<unsigned>((hash >> 32) * 12u >> 32);
  const double a = edge < 8 ? x : y, b = edge < 4 ? y : z;
  return ((edge & 1) != 0 ? -a : a) + ((edge & 2) != 0 ? -b : b);
}

double faded(double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }

/// Noise of lattice step 1 and deviation kDeviation.
double lattice_noise(const std::array<double, 3>& p, std::uint64_t key) {
  std::array<std::uint64_t, 3> cell;
  std::array<double, 3> inside, fade;
  for (std::size_t k = 0; k < 3; ++k) {
    const double whole = std::floor(p[k]);
    cell[k] = static_cast<std::uint64_t>(static_cast<std::int64_t>(whole));
    inside[k] = p[k] - whole;
    fade[k] = faded(inside[k]);
  }
  double sum = 0.0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::uint64_t hash = key;
    std::array<double, 3> from;
    double weight = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const unsigned far = corner >> k & 1;
      hash = mixed(hash + (cell[k] + far) * 0x9E3779B97F4A7C15u);
      from[k] = inside[k] - far;
      weight *= far != 0 ? fade[k] : 1.0 - fade[k];
    }
    sum += weight * slope_along(hash, from[0], from[1], from[2]);
  }
  return sum;
}

}  // namespace

void describe(OptionVisitor& v, NoiseOptions& o) {
  v.visit({"noise_wavelength", "size of what differs in `noise`: of its coarsest octave", "mm", between(1e-3, 1e9)},
          o.wavelength_mm);
  v.visit({"noise_octaves", "octaves of `noise`, each half as long and half as strong as the one before", "",
           between(1, 8)},
          o.octaves);
  v.visit({"noise_seed", "another seed is another `noise`", "", between(0, 9e15)}, o.seed);
}

double noise_at(const Vec3& position_mm, const NoiseOptions& options, double least_mm) {
  std::array<double, 3> turned;
  for (std::size_t k = 0; k < 3; ++k)
    turned[k] = kTurn[k][0] * position_mm.x() + kTurn[k][1] * position_mm.y() + kTurn[k][2] * position_mm.z();
  double sum = 0.0, squares = 0.0, wavelength = options.wavelength_mm, strength = 1.0;
  for (int octave = 0; octave < options.octaves; ++octave) {
    const std::uint64_t key =
        mixed(mixed(static_cast<std::uint64_t>(options.seed)) + static_cast<std::uint64_t>(octave));
    squares += strength * strength;
    const double seen = least_mm > 0.0 ? std::clamp(wavelength / least_mm - 1.0, 0.0, 1.0) : 1.0;
    if (!(seen > 0.0)) {
      wavelength *= 0.5;
      strength *= 0.5;
      continue;
    }
    std::array<double, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      const double shift = static_cast<double>(mixed(key + k + 1) >> 43) * 0x1p-11;  // up to 1024 steps, in 1/2048
      p[k] = turned[k] * (kStepsPerWavelength / wavelength) + shift;
    }
    sum += seen * strength * lattice_noise(p, key);
    wavelength *= 0.5;
    strength *= 0.5;
  }
  return std::clamp(0.5 + sum * (kWantedDeviation / kDeviation) / std::sqrt(squares), 0.0, 1.0);
}

}  // namespace patinate
