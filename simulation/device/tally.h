/// \file
/// What kernels count while a simulation runs on a device.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "libcommon/core/kernel_language.h"

namespace patinate::simulation {

/// tally_types.inl for C++; devices read the same text.
namespace tally_types {
using namespace kernel_types;
#include "simulation/device/tally_types.inl"
}  // namespace tally_types
/// The texts of tally_types.inl and tally.cl.
extern const std::string_view kTallyTypes, kTallyKernel;

/// A sum of the tally, modulo 2^64. @param words  The tally's. @param kind  kSegments and so on.
[[nodiscard]] inline std::int64_t counted(std::span<const std::uint32_t> words, std::uint32_t kind) {
  const std::size_t at = tally_types::kFirstCount + 2 * std::size_t{kind};
  return static_cast<std::int64_t>(words[at] | std::uint64_t{words[at + 1]} << 32);
}
/// @param kind  kMassEmitted and so on.
[[nodiscard]] inline std::int64_t mass_of(std::span<const std::uint32_t> words, std::uint32_t kind, int material) {
  const std::size_t at = tally_types::kFirstMass + 2 * (8 * std::size_t{kind} + static_cast<std::size_t>(material));
  return static_cast<std::int64_t>(words[at] | std::uint64_t{words[at + 1]} << 32);
}

}  // namespace patinate::simulation
