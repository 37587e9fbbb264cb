/// \file
/// What jobs left behind.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "libcommon/core/files.h"

namespace patinate::testing_support {

using Tree = std::map<std::string, std::string>;  ///< Relative path -> bytes ("/" for a folder).

[[nodiscard]] inline Tree tree_of(const std::filesystem::path& folder) {
  Tree tree;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    tree[entry.path().lexically_relative(folder).string()] = entry.is_directory() ? "/" : read_file(entry.path());
  return tree;
}

}  // namespace patinate::testing_support
