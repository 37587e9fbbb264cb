/// \file
/// What stands under a name of its own until it is whole: where an AtomicFile is written, and folders.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace patinate {

/// The name is one that an AtomicFile writes under, on this machine or another, or a TemporaryFolder:
/// `.STEM.tmpMACHINE-PID-PROCESS-NUMBER.EXTENSION`.
[[nodiscard]] bool is_temporary(const std::filesystem::path& path);

/// This start of the machine: another one after it was switched off. "" where the system does not say.
[[nodiscard]] std::string machine_start();

/// Says early what an AtomicFile would say. @throws CannotComplete if there is no such folder, or the path is a folder
/// or no regular file.
void require_file_place(const std::filesystem::path& path);

/// A folder of one's own beside others, to be filled and then renamed, or removed in the end. Others never write in it,
/// whatever machine they are on.
class TemporaryFolder {
 public:
  /// Makes it in `parent`, and removes there what killed processes left under the same `stem`.
  /// @throws CannotComplete
  TemporaryFolder(const std::filesystem::path& parent, std::string_view stem);
  /// Removes what it holds, unless it was renamed.
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Renames it to `place`, where nothing, or an empty folder, may be.
  /// @returns false if a folder that is not empty is there: another has been faster, and this one stays.
  /// @throws CannotComplete
  [[nodiscard]] bool move_to(const std::filesystem::path& place);

 private:
  std::filesystem::path path_;
  bool is_moved_ = false;
};

}  // namespace patinate
