#include "libcommon/core/user_cache.h"

#include <cstdlib>

namespace patinate {

namespace fs = std::filesystem;

fs::path user_cache_folder() {
  const auto absolute = [](const char* name) {
    const char* text = std::getenv(name);
    const fs::path path(text == nullptr ? "" : text);
    return path.is_absolute() ? path : fs::path();
  };
  if (const fs::path base = absolute("XDG_CACHE_HOME"); !base.empty()) return base / "patinate";
  if (const fs::path home = absolute("HOME"); !home.empty()) return home / ".cache" / "patinate";
  return {};
}

}  // namespace patinate
