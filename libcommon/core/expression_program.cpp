#include "libcommon/core/expression_program.h"

#include <algorithm>
#include <array>
#include <utility>

#include "libcommon/core/expression_kernel.h"
#include "libcommon/core/portable_math.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

constexpr int kMaxSlots = 60'000;

class Compiler {
 public:
  Compiler(const Expression& expression, const std::function<int(const ExpressionName&)>& slot_of, int first_free)
      : expression_(expression), slot_of_(slot_of), next_(first_free) {}

  ExpressionProgram compile() {
    place_constants(*expression_.root);
    program_.result = visit(*expression_.root);
    program_.num_slots = std::max(program_.num_slots, next_);
    return std::move(program_);
  }

 private:
  void place_constants(const ExpressionNode& node) {
    if (node.kind == ExpressionNode::Kind::Number)
      program_.constants.push_back({take(), static_cast<float>(node.number)});
    for (const auto& operand : node.operands) place_constants(*operand);
  }

  int take() {
    if (next_ >= kMaxSlots) throw InvalidInput("an expression is too long: it needs more than 60000 values");
    program_.num_slots = std::max(program_.num_slots, next_ + 1);
    return next_++;
  }

  /// @returns the slot of its value. Slots of operands are free again afterwards.
  int visit(const ExpressionNode& node) {
    if (node.kind == ExpressionNode::Kind::Number) return program_.constants[num_constants_++].slot;
    if (node.kind == ExpressionNode::Kind::Name) return slot_of_(expression_.names[node.name]);
    const int out = take();
    std::array<int, 3> from{};
    const bool is_chain = node.kind == ExpressionNode::Kind::Min || node.kind == ExpressionNode::Kind::Max;
    for (std::size_t i = 0; i < node.operands.size(); ++i) {
      const int value = visit(*node.operands[i]);
      if (!is_chain) {
        from[i] = value;
      } else if (i == 0 && node.operands.size() > 1) {
        from[0] = value;
      } else {  // min(a, b, c) = min(min(a, b), c)
        add(node.kind, out, {i == 0 ? value : from[0], value, 0});
        from[0] = out;
        next_ = out + 1;
      }
    }
    if (!is_chain) add(node.kind, out, from);
    next_ = out + 1;
    return out;
  }

  void add(ExpressionNode::Kind kind, int out, const std::array<int, 3>& from) {
    program_.steps.push_back({kind, static_cast<std::uint16_t>(out), static_cast<std::uint16_t>(from[0]),
                              static_cast<std::uint16_t>(from[1]), static_cast<std::uint16_t>(from[2])});
  }

  const Expression& expression_;
  const std::function<int(const ExpressionName&)>& slot_of_;
  int next_;
  std::size_t num_constants_ = 0;  ///< Visited, in the order in which they were placed.
  ExpressionProgram program_;
};

const ExpressionKernel& kernel_of(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return expression_avx512::kKernel;
  if (set == InstructionSet::Avx2) return expression_avx2::kKernel;
#endif
  return expression_baseline::kKernel;
}

namespace power_kernel {
#include "libcommon/core/expression_power.inl"
}

void power(const float* x, const float* exponent, float* out) {
  for (int i = 0; i < kExpressionBlock; ++i) out[i] = power_kernel::step_pow(x[i], exponent[i]);
}

}  // namespace

ExpressionProgram compile_expression(const Expression& expression,
                                     const std::function<int(const ExpressionName&)>& slot_of, int first_free) {
  return Compiler(expression, slot_of, first_free).compile();
}

void run_expression(const ExpressionProgram& program, float* slots, InstructionSet set) {
  const ExpressionKernel& kernel = kernel_of(set);
  for (const ExpressionStep& step : program.steps) {
    const auto slot = [&](std::uint16_t i) { return slots + std::size_t{i} * kExpressionBlock; };
    if (step.kind == ExpressionNode::Kind::Pow) {
      power(slot(step.a), slot(step.b), slot(step.out));
    } else {
      kernel.by_kind[static_cast<std::size_t>(step.kind)](slot(step.a), slot(step.b), slot(step.c), slot(step.out));
    }
  }
}

}  // namespace patinate
