/// \file
/// `OUT.partial`: where a job collects what is finished until the output is whole.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "libcommon/job/job_record.h"

namespace patinate {

/// The `"key"` in `folder / manifest`, or "" when there is no such file or it is not ours.
[[nodiscard]] std::string manifest_key(const std::filesystem::path& folder, const std::string& manifest);

/// A path under kJobWorkFolder: no part of the finished output.
[[nodiscard]] bool is_work(const std::filesystem::path& relative);
/// The folder in which `output` is made.
[[nodiscard]] std::filesystem::path partial_path(const std::filesystem::path& output);
/// Record of a finished item for other runs: its key in the first line, then the key and path of each file.
[[nodiscard]] std::string marker_text(const DoneItem& done);
[[nodiscard]] DoneItem parse_marker(const std::string& text);
/// An item whose files are all written in `folder`: forces them to the disk, and takes their keys.
/// @throws CannotComplete if an output that is not optional is missing; Canceled between files.
[[nodiscard]] DoneItem finish_item(const std::filesystem::path& folder, const JobItem& item,
                                   const std::string& item_key, const RunControl& control);
/// Forces a file, or what a folder lists, to the disk. @throws CannotComplete
void sync_path(const std::filesystem::path& path);
/// Reports an error of the file system in a job, which writes one of the two files that an error of a copy names.
/// @throws CannotComplete
[[noreturn]] void fail_written(const std::filesystem::filesystem_error& error);
/// A hard link, or a copy where the file system has none. @throws CannotComplete, filesystem_error
void link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);
/// Reads the marker of an item in a partial folder; an empty key when it is not finished.
[[nodiscard]] DoneItem read_marker(const std::filesystem::path& partial, const std::string& item);
/// Files that the item made when it was finished in a partial folder under this key of its own, and that is there; else
/// nothing. A file that is also one of the finished folder (a hard link) must still be what it was.
[[nodiscard]] std::optional<std::vector<std::filesystem::path>> finished_files(const std::filesystem::path& partial,
                                                                               const JobItem& item,
                                                                               const std::string& item_key);
/// Everything in a partial folder was made under this key and only the final rename is missing.
[[nodiscard]] bool is_partial_whole(const std::filesystem::path& partial, const std::string& manifest,
                                    const std::string& key);

/// `OUT.partial`, locked from construction to destruction. The lock is a flock on the folder itself, so it ends with
/// the process however that ends, and moves along when the folder is renamed; and one on a file in it, since network
/// file systems tell other machines of files' locks only. Book-keeping lies in `OUT.partial/.job`: `lock`; `key`; in
/// `done` one file per finished item, which holds the key of what the item was made from and those of its files; in
/// `written` one per item whose files need not be on the disk yet; and in `work` what items keep for a resumed run
/// only.
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

  /// From now on the folder is made under this key. What finished items of another plan are worth finished_files()
  /// says.
  /// @returns whether it was made under it already.
  bool begin(const std::string& key);
  /// Notes that the item's outputs are written, without waiting for the disk. It counts until the machine starts anew,
  /// and until the next run has looked at it.
  void mark_written(const JobItem& item, const std::string& item_key);
  /// Marks an item that was written under this key, and not marked, when the run before ended.
  /// @returns false if none was, or it cannot be brought to the disk. @throws Canceled
  [[nodiscard]] bool finish_written(const JobItem& item, const std::string& item_key, const RunControl& control);
  /// Before anything is written: what earlier runs noted holds no longer.
  void forget_written();
  /// Call when the item's outputs are written: forces them to the disk, then sets the marker.
  /// @throws CannotComplete if an output that is not optional is missing; Canceled.
  void mark_done(const JobItem& item, const std::string& item_key, const RunControl& control);
  /// Takes over what a finished folder holds of an item, as hard links or else copies.
  /// @returns false when its files are no longer what they were; nothing is then marked.
  bool adopt(const std::filesystem::path& finished, const JobItem& item, const DoneItem& done);
  /// Finished, or written.
  [[nodiscard]] bool has_done_items() const;
  /// Removes what interrupted items and other plans left: the markers of all items but `items`, then every file that is
  /// not in `files` (relative paths), and empty folders.
  void keep_only(const std::set<std::string>& items, const std::set<std::filesystem::path>& files,
                 const RunControl& control = {});
  /// Removes the book-keeping and renames the folder to OUT; with `replace`, exchanges the two and removes the old one.
  void publish(bool replace, const RunControl& control);
  /// Writes job.json. @param record  Its items are read from the markers of `items`; those that kept work only are left
  /// out.
  void write_record(JobRecord record, const std::set<std::string>& items, const RunControl& control);
  /// Removes the folder.
  void discard();

 private:
  void lock();
  void lock_for_other_machines();
  /// Before anything is removed: a folder whose removal was interrupted must never pass for a whole one.
  void mark_unfinished();

  std::filesystem::path output_;
  std::filesystem::path path_;
  std::string manifest_;
  int fd_ = -1;
  int file_fd_ = -1;
};

}  // namespace patinate
