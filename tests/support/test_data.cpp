#include "tests/support/test_data.h"

#include <cstdlib>

namespace patinate::testing_support {

std::optional<std::filesystem::path> real_data(const std::filesystem::path& name) {
  const char* root = std::getenv("PATINATE_DATA");
  if (root == nullptr) return std::nullopt;
  const std::filesystem::path path = std::filesystem::path(root) / name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path;
}

bool is_nightly() {
  const char* set = std::getenv("PATINATE_NIGHTLY");
  return set != nullptr && *set != '\0';
}

}  // namespace patinate::testing_support
