/// \file
/// What a program may read and write that works for others. Files name files (a history its frames, a scene its meshes,
/// a glTF its buffers), and links lead anywhere; so every reader and writer of the libraries asks here with the path
/// that it is about to open.
#pragma once

#include <filesystem>
#include <vector>

namespace patinate {

/// While it lives, this process reads only what lies below these folders. Without one, it reads everything.
class ReadLimit {
 public:
  /// One at a time. @throws IoError if one of them is no folder.
  explicit ReadLimit(const std::vector<std::filesystem::path>& folders);
  ~ReadLimit();
  ReadLimit(const ReadLimit&) = delete;
  ReadLimit& operator=(const ReadLimit&) = delete;
};

/// While it lives, this process makes files only below these folders. Without one, it makes them anywhere.
class WriteLimit {
 public:
  /// One at a time. @throws IoError if one of them is no folder.
  explicit WriteLimit(const std::vector<std::filesystem::path>& folders);
  ~WriteLimit();
  WriteLimit(const WriteLimit&) = delete;
  WriteLimit& operator=(const WriteLimit&) = delete;
};

/// Whether a path, with all links followed, lies below the folders of the ReadLimit that lives, or none does.
/// Thread-safe.
[[nodiscard]] bool may_read(const std::filesystem::path& path);
/// @throws IoError naming the path where it leads elsewhere, whether something is there or not.
void check_may_read(const std::filesystem::path& path);
/// @throws CannotComplete naming the path if its folder, with all links followed, lies outside of the WriteLimit that
/// lives.
void check_may_write(const std::filesystem::path& path);

}  // namespace patinate
