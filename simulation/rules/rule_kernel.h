/// \file
/// What rules do to the 64 texels of a tile, for one instruction set; rule_kernel.inc, compiled three times.
#pragma once

#include <cstdint>

namespace patinate::simulation {

inline constexpr int kMaxRuleTerms = 16;  ///< Makes and uses of one rule.

/// A material that a rule makes or uses.
struct RuleTerm {
  int material = 0;    ///< Slot of its amounts, and of its quanta.
  float share = 0.0F;  ///< > 0; amount by extent.
};

/// A rule for one tile. Its extent at a texel is scale * driver, less where there is not enough of what it uses.
struct KernelRule {
  float scale = 0.0F;              ///< rate * time.
  const float* driver = nullptr;   ///< Of 64 texels; negative counts as 0.
  const float* covered = nullptr;  ///< 1 or 0 for each texel.
  int num_makes = 0;
  int num_terms = 0;  ///< Uses follow the makes.
  RuleTerm terms[kMaxRuleTerms];
  std::uint32_t first_texel = 0;   ///< Random numbers belong to texels,
  std::uint32_t keys[2] = {0, 0};  ///< and to (seed, rule, time).
};

struct RuleKernel {
  /// Quanta and amounts (in 1 = kAmountOne quanta) of stored values.
  void (*load)(const std::uint16_t* stored, std::int32_t* quanta, float* amounts);
  void (*store)(const std::int32_t* quanta, std::uint16_t* stored);
  /// @param quanta,amounts  By material, 64 each; changed.
  /// @param changes  By term, 64 each: quanta made, or used.
  /// @returns bit 0: some texel has an extent; bit 1: something changed (only then are `changes` set).
  int (*apply)(const KernelRule& rule, std::int32_t* quanta, float* amounts, std::int32_t* changes);
  /// Sum of change * weight over a tile. @param changes,weights  Below 65536.
  std::int64_t (*weigh)(const std::int32_t* changes, const std::uint32_t* weights);
};

namespace rules_baseline {
extern const RuleKernel kKernel;
}
namespace rules_avx2 {
extern const RuleKernel kKernel;
}
namespace rules_avx512 {
extern const RuleKernel kKernel;
}

}  // namespace patinate::simulation
