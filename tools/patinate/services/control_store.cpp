#include "tools/patinate/services/control_store.h"

#include <cstdlib>

namespace patinate::cli {

namespace fs = std::filesystem;

void describe(OptionVisitor& v, ControlStoreOptions& o) {
  v.visit({"cache",
           "Control maps that took long are kept in the user's cache folder (~/.cache/patinate/controls) for the next "
           "command"},
          o.cache);
}

ControlCache user_control_cache(bool is_used) {
  if (!is_used) return {};
  // What is relative is to be ignored [XDG Base Directory Specification].
  const auto absolute = [](const char* name) {
    const char* text = std::getenv(name);
    const fs::path path(text == nullptr ? "" : text);
    return path.is_absolute() ? path : fs::path();
  };
  fs::path base = absolute("XDG_CACHE_HOME");
  if (base.empty()) {
    const fs::path home = absolute("HOME");
    if (home.empty()) return {};
    base = home / ".cache";
  }
  return {.folder = base / "patinate" / "controls"};
}

}  // namespace patinate::cli
