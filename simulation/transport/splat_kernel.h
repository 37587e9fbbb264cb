/// \file
/// One material of one contact: what all texels of its splat give and take, at once. Compiled for several instruction
/// sets from one source (splat_kernel.inl); each texel's result is transfer_quanta()'s (transfer.h), bit for bit.
#pragma once

#include <cstdint>

#include "libcommon/core/instruction_set.h"
#include "libcommon/core/kernel_language.h"

namespace patinate::simulation::transport {

/// Lanes, one for each texel, come in blocks of so many; those behind the last texel have shares of 0.
inline constexpr int kLaneBlock = 16;

/// All arrays are by lane.
struct SplatLanes {
  int num = 0;                            ///< A multiple of kLaneBlock.
  int middle = 0;                         ///< The lane that is hit.
  const std::uint32_t* number = nullptr;  ///< Number of the splat's parts: for random numbers.
  const std::uint32_t* before = nullptr;  ///< Shares of all parts before this one, in 1 / SplatShape::kWhole;
  const std::uint32_t* after = nullptr;   ///< with this one.
  const double* up = nullptr;             ///< TransferShares.
  const double* down = nullptr;
  const std::uint16_t* weight = nullptr;
  std::uint32_t middle_weight = 1;
  bool is_even = false;  ///< All weights are the middle's.
  const std::uint16_t* amount = nullptr;
  std::uint32_t whole = 0;         ///< Mass that is carried.
  std::uint32_t room = 0;          ///< Mass that each part may pick up.
  std::uint32_t random = 0;        ///< Random number of the contact and material.
  std::int32_t* quanta = nullptr;  ///< Result: what leaves each texel.
  std::uint16_t* left = nullptr;   ///< Result: its amount then.
  std::uint16_t* any = nullptr;    ///< Not 0 from now on where something has changed.
};

/// Mass that went from texels to the gammaton, and the other way; added to.
struct SplatSums {
  std::int64_t picked_up = 0;
  std::int64_t dropped = 0;
};

using SplatKernel = void (*)(const SplatLanes& lanes, SplatSums& sums);

/// @param set  One that the machine has.
[[nodiscard]] SplatKernel splat_kernel(InstructionSet set);

}  // namespace patinate::simulation::transport
