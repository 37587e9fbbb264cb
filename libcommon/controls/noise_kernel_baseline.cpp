#define PATINATE_KERNEL_NAMESPACE noise_baseline
#include "libcommon/controls/noise_kernel.inc"
