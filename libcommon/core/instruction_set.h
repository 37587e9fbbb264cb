/// \file
/// Hot kernels are compiled from one source for several instruction sets and chosen here at run time. Their results
/// agree bit for bit (doubles and floats with + - * / and sqrt alone, compiled with -ffp-contract=off), so the choice
/// is one of speed only.
#pragma once

#include <array>
#include <string_view>

namespace patinate {

enum class InstructionSet { Baseline, Avx2, Avx512 };
inline constexpr std::array<std::string_view, 3> kInstructionSetNames{"baseline", "avx2", "avx512"};

/// Whether this machine and this build have it. Avx512 means F, BW, DQ and VL.
[[nodiscard]] bool has_instruction_set(InstructionSet set);

/// Set that the environment variable PATINATE_ISA names, else the best that the machine has.
/// @throws InvalidInput if it names none of kInstructionSetNames, or one that is not there.
[[nodiscard]] InstructionSet instruction_set();

}  // namespace patinate
