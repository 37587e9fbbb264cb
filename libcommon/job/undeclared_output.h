/// \file
/// Files that items of a job write without saying so. Inside of jobs only.
#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <set>
#include <string>

#include "libcommon/job/job.h"
#include "patinate/core/error.h"

namespace patinate {

/// A file that no item declares lies in the folder: a fault of the plan. A run that was killed and resumes would lose
/// it without a word.
class UndeclaredOutput : public CannotComplete {
 public:
  using CannotComplete::CannotComplete;
};

/// Looks at a job's folder while items of one stage run, and at least before the last of them counts as finished. All
/// files are looked at after the first item, the second, the fourth and so on, so that it costs no more than the items'
/// own files. Thread-safe.
class UndeclaredSearch {
 public:
  UndeclaredSearch(const JobPlan& plan, std::filesystem::path folder, std::size_t num_items);
  /// Call when an item has written its files, and before it is marked. @throws UndeclaredOutput, Canceled
  void finished(const std::string& item, const RunControl& control);

 private:
  void search(const std::string& item, const RunControl& control) const;

  std::set<std::filesystem::path> declared_;
  std::filesystem::path folder_;
  std::size_t num_items_;
  std::atomic<std::size_t> num_finished_{0};
};

}  // namespace patinate
