/// \file
/// Counter-based random numbers: a value depends on (seed, item, draw), never on a thread or on what was drawn before
/// for another item. Philox 4x32-10 [Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3"].
#pragma once

#include <array>
#include <cstdint>

#include "libcommon/core/kernel_language.h"

namespace patinate {

/// philox.inl for C++; devices read the same text.
namespace random_kernel {
using namespace kernel_types;
#include "libcommon/core/philox.inl"
}  // namespace random_kernel
/// The text of philox.inl.
extern const std::string_view kPhiloxKernel;

/// The Philox 4x32-10 bijection. Checked against the authors' known-answer vectors.
[[nodiscard]] std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                                      std::array<std::uint32_t, 2> key);

/// The random stream of one item (a texel, a particle, a frame).
class RandomStream {
 public:
  /// @param purpose  Keeps two uses of the same seed apart; any constant.
  RandomStream(std::uint64_t seed, std::uint64_t item, std::uint32_t purpose = 0)
      : state_(random_kernel::random_state(seed, item, purpose)) {}

  [[nodiscard]] std::uint32_t next_u32() { return random_kernel::random_next(&state_); }
  /// Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform();
  /// Uniform in [0, n), n > 0; without bias.
  [[nodiscard]] std::uint32_t below(std::uint32_t n) { return random_kernel::random_below(&state_, n); }
  /// Standard normal (sum-free, Box-Muller).
  [[nodiscard]] double normal();

 private:
  random_kernel::RandomState state_;
};

}  // namespace patinate
