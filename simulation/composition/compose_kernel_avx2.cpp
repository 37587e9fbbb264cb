#include "simulation/composition/compose_kernel.h"

namespace patinate::simulation::composition::avx2 {
#include "simulation/composition/compose_kernel.inl"
}  // namespace patinate::simulation::composition::avx2
