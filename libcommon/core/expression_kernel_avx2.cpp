#define PATINATE_KERNEL_NAMESPACE expression_avx2
#include "libcommon/core/expression_kernel.inc"
