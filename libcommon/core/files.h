/// \file
/// Files that are whole or absent.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace patinate {

/// A file that is written beside its place and gets there when it is whole. Thread-safe towards others and
/// abandon_atomic_files().
class AtomicFile {
 public:
  /// @throws CannotComplete if there is no such folder, or the path is a folder or no regular file.
  explicit AtomicFile(std::filesystem::path path);
  /// Removes the temporary file unless finished.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  /// Where to write; same extension.
  [[nodiscard]] const std::filesystem::path& temporary() const { return temporary_; }
  /// Renames it over `path`. @throws CannotComplete if it is not there or the disk is full.
  void finish();
  /// Finishes without waiting for the disk: after a power cut the file may hold anything. For files that carry a
  /// checksum.
  void finish_unsynced();

 private:
  void move_to_place();

  std::filesystem::path path_, temporary_;
  bool is_finished_ = false;
};

/// For a process that ends at once, whatever its threads are doing: removes all temporary files. Whoever wants to begin
/// or finish an AtomicFile from then on waits for the end, and no file at all can be opened. Call it right before
/// _exit().
void abandon_atomic_files();

/// Removes what killed writers of an AtomicFile left in `folder` in place of files whose names begin with `prefix`;
/// other machines' after a week.
void remove_abandoned(const std::filesystem::path& folder, std::string_view prefix);

/// Calls `write` with a temporary path beside `path` (same extension), then renames it over `path`.
/// @throws CannotComplete if the folder cannot be written or the disk is full; `path` is then untouched.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path&)>& write);
/// Writes the given bytes.
void write_atomically(const std::filesystem::path& path, std::string_view bytes);
/// The whole file. @throws IoError if it cannot be read or holds more than `max_bytes`.
[[nodiscard]] std::string read_file(const std::filesystem::path& path,
                                    std::uint64_t max_bytes = std::uint64_t{1} << 32);
/// Where a file lies: "." for a name without a folder, whose parent_path() is empty and can be neither listed nor made.
[[nodiscard]] std::filesystem::path folder_of(const std::filesystem::path& path);
/// The folder that a user means by it or by its manifest: "copper", "copper/history.json", or "history.json" inside it
/// (then ".").
[[nodiscard]] std::filesystem::path manifest_folder(const std::filesystem::path& path, std::string_view manifest_name);
/// Whether a name matches a pattern: `*` stands for any characters, `?` for one.
[[nodiscard]] bool matches_pattern(std::string_view name, std::string_view pattern);
/// Files of `folder` (empty: the working folder) whose names match `pattern`, in natural order: "2.png" before
/// "10.png", "0.25.png" before "0.5.png"; where names count on from 1.9 to 1.10, a point separates two numbers.
/// @throws IoError if the folder cannot be listed.
[[nodiscard]] std::vector<std::filesystem::path> list_files(const std::filesystem::path& folder,
                                                            std::string_view pattern);

}  // namespace patinate
