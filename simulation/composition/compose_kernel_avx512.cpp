#include "simulation/composition/compose_kernel.h"

namespace patinate::composition::avx512 {
#include "simulation/composition/compose_kernel.inl"
}  // namespace patinate::composition::avx512
