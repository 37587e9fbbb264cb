#define PATINATE_KERNEL_NAMESPACE rules_baseline
#include "simulation/rules/rule_kernel.inc"
