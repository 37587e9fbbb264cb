/// \file
/// `OUT.items`: finished items of a plan, where machines that know nothing of each other make an output together.
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "libcommon/job/job.h"
#include "libcommon/job/job_record.h"

namespace patinate {

/// Every finished item is a folder `OUT.items/NAME-KEY`, which appears by one rename within `OUT.items`: it is whole or
/// absent, whoever else makes the same item at the same time, and no lock, process id or clock decides about it. It
/// holds the item's files, and in `.job/item` its marker. What begins with a dot is somebody's unfinished work.
class ItemStore {
 public:
  /// @param plan  Must outlive this.
  explicit ItemStore(const JobPlan& plan);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Makes the folder. @throws CannotComplete if it cannot be made, or holds what is not ours.
  void open() const;
  /// Looks at what there is. A network file system tells of other machines' items when the folder is opened again.
  void refresh();
  /// It was there at the last refresh().
  [[nodiscard]] bool has(const JobItem& item) const;
  /// Reads the files of a finished item. @throws CannotComplete if it is gone or damaged.
  [[nodiscard]] DoneItem read(const JobItem& item) const;
  /// Links the files of a finished item into `folder`, and what it left of the plan's shared work, which may be gone.
  /// @throws CannotComplete if another file is gone.
  void take(const JobItem& item, const std::filesystem::path& folder) const;
  /// Keeps an item whose files are written in `folder`, and links of the plan's shared work there. Thread-safe.
  /// @throws CannotComplete if an output is missing, or the disk is full; Canceled.
  void add(const JobItem& item, const std::filesystem::path& folder, const RunControl& control) const;
  /// Removes what an item left of the plan's shared work: a later one has its own.
  void drop_shared_work(const JobItem& item) const;
  /// Removes the plan's items and what killed processes left, and the folder if nothing else is in it.
  void remove_all() const;

 private:
  [[nodiscard]] std::string name_of(const JobItem& item) const;

  const JobPlan& plan_;
  std::filesystem::path path_;
  std::set<std::string> names_;  ///< Names of the folders that there are.
};

}  // namespace patinate
