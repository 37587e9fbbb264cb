#define PATINATE_KERNEL_NAMESPACE rules_avx2
#include "simulation/rules/rule_kernel.inc"
