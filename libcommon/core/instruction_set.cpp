#include "libcommon/core/instruction_set.h"

#include <cstdlib>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

bool has_instruction_set(InstructionSet set) {
  switch (set) {
    case InstructionSet::Baseline:
      return true;
#if defined(__x86_64__)
    case InstructionSet::Avx2:
      return __builtin_cpu_supports("avx2") != 0;
    case InstructionSet::Avx512:
      return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
             __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
#endif
    default:
      return false;
  }
}

InstructionSet instruction_set() {
  if (const char* asked = std::getenv("PATINATE_ISA"); asked != nullptr && *asked != '\0') {
    for (std::size_t i = 0; i < kInstructionSetNames.size(); ++i) {
      if (kInstructionSetNames[i] != asked) continue;
      if (has_instruction_set(static_cast<InstructionSet>(i))) return static_cast<InstructionSet>(i);
      throw InvalidInput("PATINATE_ISA is `" + std::string(asked) + "`; this machine does not have it");
    }
    const std::vector<std::string> names(kInstructionSetNames.begin(), kInstructionSetNames.end());
    throw InvalidInput("PATINATE_ISA is `" + std::string(asked) + "`; use baseline, avx2 or avx512" +
                       did_you_mean(asked, names));
  }
  if (has_instruction_set(InstructionSet::Avx512)) return InstructionSet::Avx512;
  return has_instruction_set(InstructionSet::Avx2) ? InstructionSet::Avx2 : InstructionSet::Baseline;
}

}  // namespace patinate
