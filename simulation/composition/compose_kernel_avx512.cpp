#include "simulation/composition/compose_kernel.h"

namespace patinate::simulation::composition::avx512 {
#include "simulation/composition/compose_kernel.inl"
#include "simulation/composition/compose_kernel_cpu.inl"
}  // namespace patinate::simulation::composition::avx512
