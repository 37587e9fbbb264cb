/// \file
/// The steps of ExpressionProgram for one instruction set; expression_kernel.inl, compiled three times and by devices.
#pragma once

#include <string_view>

namespace patinate {

/// The texts of expression_kernel.inl and expression_power.inl, which stands behind portable_math.inl.
extern const std::string_view kExpressionKernel, kExpressionPower;

/// out = f(a, b, c) over kExpressionBlock floats; operands that a kind lacks are not read. `out` may not overlap the
/// others except be a.
using ExpressionFunction = void (*)(const float* a, const float* b, const float* c, float* out);

struct ExpressionKernel {
  ExpressionFunction by_kind[14];  ///< By ExpressionNode::Kind; null for numbers, names and pow.
};

namespace expression_baseline {
extern const ExpressionKernel kKernel;
}
namespace expression_avx2 {
extern const ExpressionKernel kKernel;
}
namespace expression_avx512 {
extern const ExpressionKernel kKernel;
}

}  // namespace patinate
