/// \file
/// An octave of noise at many places, for one instruction set; noise_kernel.inc, compiled three times.
#pragma once

#include <cstdint>

#include "libcommon/core/instruction_set.h"

namespace patinate {

inline constexpr int kNoiseBlock = 64;  ///< Places at most.

/// An octave: at a place p it is strength * noise of the lattice's point p * scale + shift.
struct NoiseOctave {
  double scale = 1.0;
  double shift[3] = {0.0, 0.0, 0.0};
  std::uint64_t key = 0;
  double strength = 1.0;
};

struct NoiseKernel {
  /// sum[i] += the octave at (x[i], y[i], z[i]), for `count` <= kNoiseBlock places.
  void (*add)(const NoiseOctave& octave, const double* x, const double* y, const double* z, int count, double* sum);
};

/// @param set  One that the machine has; results do not depend on it.
[[nodiscard]] const NoiseKernel& noise_kernel(InstructionSet set);

namespace noise_baseline {
extern const NoiseKernel kKernel;
}
namespace noise_avx2 {
extern const NoiseKernel kKernel;
}
namespace noise_avx512 {
extern const NoiseKernel kKernel;
}

}  // namespace patinate
