#include "simulation/composition/compose_kernel.h"

namespace patinate::composition::baseline {
#include "simulation/composition/compose_kernel.inl"
}  // namespace patinate::composition::baseline
