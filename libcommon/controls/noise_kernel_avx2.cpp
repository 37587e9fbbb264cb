#define PATINATE_KERNEL_NAMESPACE noise_avx2
#include "libcommon/controls/noise_kernel.inc"
