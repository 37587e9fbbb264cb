#define PATINATE_KERNEL_NAMESPACE reach_avx512
#include "transfer/synthesis/reach_kernel.inc"
