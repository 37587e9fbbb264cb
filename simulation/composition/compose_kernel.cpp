#include "simulation/composition/compose_kernel.h"

namespace patinate::simulation::composition {

namespace baseline {
extern const Kernels kKernels;
}
namespace avx2 {
extern const Kernels kKernels;
}
namespace avx512 {
extern const Kernels kKernels;
}

const Kernels& kernels(InstructionSet set) {
  switch (set) {
    case InstructionSet::Avx512:
      return avx512::kKernels;
    case InstructionSet::Avx2:
      return avx2::kKernels;
    case InstructionSet::Baseline:
      break;
  }
  return baseline::kKernels;
}

}  // namespace patinate::simulation::composition
