#include "tools/studio/plane_hash.h"

#include <xxhash.h>

#include <array>
#include <cstdio>

namespace patinate::studio {

std::string xxh64(std::string_view bytes) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(XXH64(bytes.data(), bytes.size(), 0)));
  return text.data();
}

}  // namespace patinate::studio
