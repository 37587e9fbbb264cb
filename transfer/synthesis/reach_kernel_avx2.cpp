#define PATINATE_KERNEL_NAMESPACE reach_avx2
#include "transfer/synthesis/reach_kernel.inc"
