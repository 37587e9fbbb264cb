#include "simulation/rules/rule_kernel.h"

namespace patinate::simulation::rules_baseline {
using namespace rule_types;
#include "simulation/rules/rule_kernel.inl"
#include "simulation/rules/rule_kernel_cpu.inl"
}  // namespace patinate::simulation::rules_baseline
