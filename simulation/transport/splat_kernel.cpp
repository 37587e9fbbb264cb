#include "simulation/transport/splat_kernel.h"

namespace patinate::simulation::transport {

namespace splat_baseline {
extern const SplatKernel kKernel;
}
namespace splat_avx2 {
extern const SplatKernel kKernel;
}
namespace splat_avx512 {
extern const SplatKernel kKernel;
}

SplatKernel splat_kernel(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return splat_avx512::kKernel;
  if (set == InstructionSet::Avx2) return splat_avx2::kKernel;
#endif
  (void)set;
  return splat_baseline::kKernel;
}

}  // namespace patinate::simulation::transport
