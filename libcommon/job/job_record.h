/// \file
/// `job.json` in a finished folder: what it was made from and which item made which file, so that a later plan can say
/// what changed and keep what did not. It holds content only: equal work gives equal bytes.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/job/job.h"

namespace patinate {

inline constexpr const char* kJobRecordFile = "job.json";

/// A finished item: what it was made from, and its files as they were.
struct DoneItem {
  std::string key;
  std::map<std::string, std::string> files;  ///< Path relative to the folder -> key of its bytes.
};

struct JobRecord {
  std::string key;  ///< The plan's; "" = there is no record.
  std::vector<JobDependency> depends_on;
  std::map<std::string, DoneItem> items;
};

/// The record of a folder; an empty one when it has none, it is damaged, or it belongs to another manifest.
/// @param key  The manifest's.
[[nodiscard]] JobRecord read_job_record(const std::filesystem::path& folder, const std::string& key);
/// @throws CannotComplete
void write_job_record(const std::filesystem::path& folder, const JobRecord& record);

/// What the item made, as `done` says: all of its outputs and some optional ones; nothing if that is not what it
/// declares.
[[nodiscard]] std::optional<std::vector<std::filesystem::path>> made_files(const JobItem& item, const DoneItem& done);

/// The files, as `done` says they were, lie in `folder` and are still the same bytes.
[[nodiscard]] bool is_unchanged(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& outputs,
                                const DoneItem& done);

/// How one thing that a plan depends on differs from what a finished folder was made from.
struct JobChange {
  enum class Kind { Added, Removed, Changed } kind = Kind::Changed;
  std::string name;
  std::string before;  ///< "" when added.
  std::string now;     ///< "" when removed.
};
/// In the order of `now`, then what is gone.
[[nodiscard]] std::vector<JobChange> changes_between(const std::vector<JobDependency>& before,
                                                     const std::vector<JobDependency>& now);

}  // namespace patinate
