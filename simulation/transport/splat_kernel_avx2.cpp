#include "simulation/transport/splat_kernel.h"

namespace patinate::simulation::transport::splat_avx2 {
#include "simulation/transport/splat_kernel.inl"
}  // namespace patinate::simulation::transport::splat_avx2
