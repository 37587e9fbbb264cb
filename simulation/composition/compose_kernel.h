/// \file
/// The inner loops of composition: a tile of 64 texels from integers to integers, compiled for several instruction sets
/// from one source (compose_kernel.inl). Every result is defined by integer arithmetic alone, so that all of them, and
/// another device, give the same bytes.
#pragma once

#include <cstdint>
#include <string_view>

#include "libcommon/core/instruction_set.h"
#include "libcommon/core/kernel_language.h"

namespace patinate::simulation::composition {

using namespace kernel_types;
#include "simulation/composition/compose_types.inl"

inline constexpr int kHeightQuanta = 1024;  ///< In the size of a median texel.
inline constexpr int kSrgbSize = 65536 >> kSrgbShift;

/// The texts of compose_types.inl, compose_kernel.inl and compose_device.cl.
extern const std::string_view kComposeTypes, kComposeKernel, kComposeEntries;

/// Slopes along T and B, 1 = kSlopeOne, in [-kMaxSlope, kMaxSlope].
struct SlopeTile {
  alignas(64) std::int32_t along_t[kTile];
  alignas(64) std::int32_t along_b[kTile];
};

struct Kernels {
  /// Colors as R | G << 8 | B << 16 | specular << 24, and heights in quanta.
  void (*compose)(const ComposeTask& task, std::uint32_t* rgba, std::int32_t* height);
  void (*slopes)(const NormalTask& task, SlopeTile& slopes);
  /// 3 x 64 bytes: x, y, z as 127.5 + 127.5 n, rounded.
  void (*encode)(const SlopeTile& slopes, std::uint8_t* normal);
  /// Slope of a texel on a border, along T (weights: along_t) or B.
  std::int32_t (*border_slope)(const BorderTexel* texel, const std::int32_t* weights, const std::int32_t* heights);
  /// Copies `num_words` (a multiple of 16) and tells whether any was different.
  bool (*replace)(std::uint32_t* to, const std::uint32_t* from, int num_words);
};

/// @param set  One that the machine has.
[[nodiscard]] const Kernels& kernels(InstructionSet set);

}  // namespace patinate::simulation::composition
