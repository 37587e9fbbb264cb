/// \file
/// Where the program keeps control maps between commands.
#pragma once

#include "libcommon/controls/control_cache.h"
#include "patinate/core/options.h"

namespace patinate::app {

struct ControlStoreOptions {
  bool cache = true;  ///< No result depends on it.
};
void describe(OptionVisitor& v, ControlStoreOptions& o);

/// `patinate/controls` in the user's cache folder ($XDG_CACHE_HOME, else ~/.cache); a cache without folder, which keeps
/// nothing, where there is none or `is_used` is false.
[[nodiscard]] ControlCache user_control_cache(bool is_used);

}  // namespace patinate::app
