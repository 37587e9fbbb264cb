/// \file
/// Expressions as a list of steps over blocks of 64 floats: fast, with the same bits for every instruction set, and
/// never NaN or infinite.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "libcommon/core/expression.h"
#include "libcommon/core/instruction_set.h"

namespace patinate {

inline constexpr int kExpressionBlock = 64;

/// out = kind(a, b, c), of slots.
struct ExpressionStep {
  ExpressionNode::Kind kind;
  std::uint16_t out, a, b, c;
};

/// A compiled expression. Its values lie in slots of kExpressionBlock floats each: inputs that the caller fills, then
/// its constants, then what it works with.
struct ExpressionProgram {
  struct Constant {
    int slot;
    float value;
  };
  std::vector<ExpressionStep> steps;
  std::vector<Constant> constants;  ///< To be written to their slots once; no step overwrites them.
  int result = 0;                   ///< Slot with the value after the steps; may be an input's or a constant's.
  int num_slots = 0;                ///< Beyond the last that it uses.
};

/// @param slot_of     Slot of each name, below `first_free`.
/// @param first_free  Slots from here are the program's own.
/// @throws InvalidInput if it needs more than 60000 slots.
[[nodiscard]] ExpressionProgram compile_expression(const Expression& expression,
                                                   const std::function<int(const ExpressionName&)>& slot_of,
                                                   int first_free);

/// Runs the steps, on whole blocks. Floats; results within +-kExpressionHuge; x / 0 = 0; pow(x, y) of max(0, x), 0
/// where x and y < 0.
/// @param slots  num_slots * kExpressionBlock values, aligned to 64 bytes; inputs within +-kExpressionHuge.
void run_expression(const ExpressionProgram& program, float* slots, InstructionSet set);

}  // namespace patinate
