#define PATINATE_KERNEL_NAMESPACE reach_baseline
#include "transfer/synthesis/reach_kernel.inc"
