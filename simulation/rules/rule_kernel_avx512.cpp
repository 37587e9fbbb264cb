#define PATINATE_KERNEL_NAMESPACE rules_avx512
#include "simulation/rules/rule_kernel.inc"
