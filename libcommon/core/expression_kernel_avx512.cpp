#define PATINATE_KERNEL_NAMESPACE expression_avx512
#include "libcommon/core/expression_kernel.inc"
