#include "simulation/composition/compose_kernel.h"

namespace patinate::simulation::composition::avx512 {
#include "simulation/composition/compose_kernel.inl"
}  // namespace patinate::simulation::composition::avx512
