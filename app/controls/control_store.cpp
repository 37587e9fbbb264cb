#include "app/controls/control_store.h"

#include "libcommon/core/user_cache.h"

namespace patinate::app {

void describe(OptionVisitor& v, ControlStoreOptions& o) {
  v.visit({"cache",
           "Keep control maps that took long to compute in the user's cache folder (~/.cache/patinate/controls) for "
           "later commands"},
          o.cache);
}

ControlCache user_control_cache(bool is_used) {
  const std::filesystem::path folder = is_used ? user_cache_folder() : std::filesystem::path();
  return folder.empty() ? ControlCache{} : ControlCache{.folder = folder / "controls"};
}

}  // namespace patinate::app
