#include "patinate/controls/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "libcommon/controls/noise_kernel.h"

namespace patinate {

namespace {

/// Lattice steps in a wavelength: noise on a lattice of step 1 rises through its mean 0.422 times a step (measured over
/// 2,000,000 steps in four directions).
constexpr double kStepsPerWavelength = 2.37;
constexpr double kDeviation = 0.27;  ///< Deviation of noise on such a lattice, measured with it.
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

const NoiseKernel& best_kernel() {
  static const NoiseKernel& kernel = noise_kernel(instruction_set());
  return kernel;
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

const NoiseKernel& noise_kernel([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return noise_avx512::kKernel;
  if (set == InstructionSet::Avx2) return noise_avx2::kKernel;
#endif
  return noise_baseline::kKernel;
}

double noise_at(const Vec3& position_mm, const NoiseOptions& options, double least_mm) {
  double value = 0.0;
  noise_at(std::span(&position_mm, 1), options, least_mm, std::span(&value, 1));
  return value;
}

void noise_at(std::span<const Vec3> positions_mm, const NoiseOptions& options, double least_mm,
              std::span<double> values) {
  const NoiseKernel& kernel = best_kernel();
  std::array<std::array<double, kNoiseBlock>, 3> turned;
  std::array<double, kNoiseBlock> sum;
  for (std::size_t first = 0; first < positions_mm.size(); first += kNoiseBlock) {
    const std::size_t count = std::min<std::size_t>(kNoiseBlock, positions_mm.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3& p = positions_mm[first + i];
      for (std::size_t k = 0; k < 3; ++k)
        turned[k][i] = kTurn[k][0] * p.x() + kTurn[k][1] * p.y() + kTurn[k][2] * p.z();
      sum[i] = 0.0;
    }
    double squares = 0.0, wavelength = options.wavelength_mm, strength = 1.0;
    for (int octave = 0; octave < options.octaves; ++octave, wavelength *= 0.5, strength *= 0.5) {
      squares += strength * strength;
      const double seen = least_mm > 0.0 ? std::clamp(wavelength / least_mm - 1.0, 0.0, 1.0) : 1.0;
      if (!(seen > 0.0)) continue;
      const std::uint64_t key =
          mixed(mixed(static_cast<std::uint64_t>(options.seed)) + static_cast<std::uint64_t>(octave));
      NoiseOctave form{.scale = kStepsPerWavelength / wavelength, .key = key, .strength = seen * strength};
      for (std::size_t k = 0; k < 3; ++k)
        form.shift[k] = static_cast<double>(mixed(key + k + 1) >> 43) * 0x1p-11;  // up to 1024 steps, in 1/2048
      kernel.add(form, turned[0].data(), turned[1].data(), turned[2].data(), static_cast<int>(count), sum.data());
    }
    for (std::size_t i = 0; i < count; ++i) {
      values[first + i] = std::clamp(0.5 + sum[i] * (kWantedDeviation / kDeviation) / std::sqrt(squares), 0.0, 1.0);
    }
  }
}

}  // namespace patinate
