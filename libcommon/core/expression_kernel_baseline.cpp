#define PATINATE_KERNEL_NAMESPACE expression_baseline
#include "libcommon/core/expression_kernel.inc"
