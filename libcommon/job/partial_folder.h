/// \file
/// `OUT.partial`: where a job collects what is finished until the output is whole.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "libcommon/job/job_record.h"

namespace patinate {

/// The `"key"` in `folder / manifest`, or "" when there is no such file or it is not ours.
[[nodiscard]] std::string manifest_key(const std::filesystem::path& folder, const std::string& manifest);

/// The folder in which `output` is made.
[[nodiscard]] std::filesystem::path partial_path(const std::filesystem::path& output);
/// What the marker in a partial folder says about an item; an empty key when it is not finished.
[[nodiscard]] DoneItem read_marker(const std::filesystem::path& partial, const std::string& item);
/// The item was finished in a partial folder under this key of its own, and its outputs are there. An output that is also a
/// file of the finished folder (a hard link) must still be what it was.
[[nodiscard]] bool is_item_done(const std::filesystem::path& partial, const std::string& item, const std::string& item_key,
                                const std::vector<std::filesystem::path>& outputs);
/// Everything in a partial folder was made under this key and only the final rename is missing.
[[nodiscard]] bool is_partial_whole(const std::filesystem::path& partial, const std::string& manifest, const std::string& key);

/// `OUT.partial`, locked from construction to destruction. The lock is a flock on the folder itself, so it ends with
/// the process however that ends, and moves along when the folder is renamed. Book-keeping lies in `OUT.partial/.job`:
/// `key`; in `done` one file per finished item, which holds the key of what the item was made from and those of its files; and in
/// `work` what items keep for a resumed run only.
class PartialFolder {
 public:
  /// Makes or opens the folder and locks it.
  /// @throws CannotComplete if it cannot be made or locked, another process holds it, or it holds files that are not
  /// ours.
  PartialFolder(const std::filesystem::path& output, std::string manifest);
  ~PartialFolder();
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// From now on the folder is made under this key. What finished items of another plan are worth is_done() says.
  void begin(const std::string& key);
  /// Call when the item's outputs are written: forces them to the disk, then sets the marker.
  /// @throws CannotComplete if an output is missing.
  void mark_done(const std::string& item, const std::string& item_key,
                 const std::vector<std::filesystem::path>& outputs);
  /// Takes over what a finished folder holds of an item, as hard links or else copies.
  /// @returns false when its files are no longer what they were; nothing is then marked.
  bool adopt(const std::filesystem::path& finished, const std::string& item, const DoneItem& done,
             const std::vector<std::filesystem::path>& outputs);
  [[nodiscard]] bool has_done_items() const;
  /// Removes what interrupted items and other plans left: the markers of all items but `items`, then every file that is
  /// not in `files` (relative paths), and empty folders.
  void keep_only(const std::set<std::string>& items, const std::set<std::filesystem::path>& files);
  /// Removes the book-keeping and renames the folder to OUT; with `replace`, exchanges the two and removes the old one.
  void publish(bool replace);
  /// Writes job.json. @param record  Its items are read from the markers of `items`; those that kept work only are left out.
  void write_record(JobRecord record, const std::set<std::string>& items);
  /// Removes the folder.
  void discard();

 private:
  void lock();
  /// Before anything is removed: a folder whose removal was interrupted must never pass for a whole one.
  void mark_unfinished();

  std::filesystem::path output_;
  std::filesystem::path path_;
  std::string manifest_;
  int fd_ = -1;
};

}  // namespace patinate
