/// \file
/// Where a user keeps what can be made again.
#pragma once

#include <filesystem>

namespace patinate {

/// `patinate` in $XDG_CACHE_HOME, else in ~/.cache; empty where the environment names neither by an absolute path (what
/// is relative is to be ignored [XDG Base Directory Specification]). It need not exist.
[[nodiscard]] std::filesystem::path user_cache_folder();

}  // namespace patinate
