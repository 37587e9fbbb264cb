/// \file
/// The steps of ExpressionProgram for one instruction set; expression_kernel.inc, compiled three times.
#pragma once

namespace patinate {

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
