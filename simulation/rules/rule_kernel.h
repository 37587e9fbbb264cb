/// \file
/// What rules do to the 64 texels of a tile: rule_kernel.inl, compiled for three instruction sets and by devices.
#pragma once

#include <cstdint>
#include <string_view>

#include "libcommon/core/kernel_language.h"

namespace patinate::simulation {

namespace rule_types {
using namespace kernel_types;
#include "simulation/rules/rule_types.inl"
}  // namespace rule_types
using rule_types::KernelRule;

/// The texts of rule_types.inl, rule_kernel.inl and rule_device.cl.
extern const std::string_view kRuleTypes, kRuleKernel, kRuleEntries;

inline constexpr int kMaxRuleTerms = 16;  ///< Makes and uses of one rule.
static_assert(sizeof(KernelRule::terms) / sizeof(KernelRule::terms[0]) == kMaxRuleTerms);

struct RuleKernel {
  /// Quanta and amounts (in 1 = kAmountOne quanta) of stored values.
  void (*load)(const std::uint16_t* stored, std::int32_t* quanta, float* amounts);
  void (*store)(const std::int32_t* quanta, std::uint16_t* stored);
  /// @param driver   Of 64 texels; negative counts as 0.
  /// @param covered  1 or 0 for each texel.
  /// @param quanta,amounts  By material, 64 each; changed.
  /// @param changes  By term, 64 each: quanta made, or used.
  /// @returns bit 0: some texel has an extent; bit 1: something changed (only then are `changes` set).
  int (*apply)(const KernelRule& rule, const float* driver, const float* covered, std::uint32_t first_texel,
               std::int32_t* quanta, float* amounts, std::int32_t* changes);
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
