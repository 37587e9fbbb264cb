#include "simulation/rules/rule_kernel.h"

namespace patinate::simulation::rules_avx2 {
using namespace rule_types;
#include "simulation/rules/rule_kernel.inl"
#include "simulation/rules/rule_kernel_cpu.inl"
}  // namespace patinate::simulation::rules_avx2
