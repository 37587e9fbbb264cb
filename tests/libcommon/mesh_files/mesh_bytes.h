/// \file
/// Meshes from bytes, through a file of a name.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "patinate/core/error.h"
#include "patinate/mesh_files/mesh_io.h"
#include "tests/support/temp_folder.h"

namespace patinate::testing_support {

inline std::filesystem::path write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// Error of read_mesh() about a file with these bytes; "" when it reads it.
inline std::string error_of(const std::string& name, const std::string& bytes) {
  const TempFolder folder;
  try {
    (void)read_mesh(write(folder / name, bytes));
    return "";
  } catch (const IoError& e) {
    const std::string text = e.what(), path = (folder / name).string();
    EXPECT_EQ(text.compare(0, path.size() + 2, path + ": "), 0) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text.substr(std::min(text.size(), path.size() + 2));
  }
}

inline Mesh mesh_of(const std::string& name, const std::string& bytes) {
  const TempFolder folder;
  return read_mesh(write(folder / name, bytes));
}

}  // namespace patinate::testing_support
