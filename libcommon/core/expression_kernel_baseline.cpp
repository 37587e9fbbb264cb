#include "libcommon/core/expression_kernel.h"

namespace patinate::expression_baseline {
#include "libcommon/core/expression_kernel.inl"
#include "libcommon/core/expression_kernel_cpu.inl"
}  // namespace patinate::expression_baseline
