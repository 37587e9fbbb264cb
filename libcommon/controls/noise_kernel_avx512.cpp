#define PATINATE_KERNEL_NAMESPACE noise_avx512
#include "libcommon/controls/noise_kernel.inc"
