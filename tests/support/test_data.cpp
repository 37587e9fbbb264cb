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

}  // namespace patinate::testing_support
