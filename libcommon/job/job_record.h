/// \file
/// `job.json` in a finished folder: what it was made from and which item made which file, so that a later plan can say
/// what changed and keep what did not. It holds content only: equal work gives equal bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/job/job.h"

namespace patinate {

inline constexpr const char* kJobRecordFile = "job.json";
inline constexpr const char* kRunRecordFile = "run.json";  ///< See write_run_record().

/// A finished item: what it was made from, and its files as they were.
struct DoneItem {
  std::string key;
  std::map<std::string, std::string> files;  ///< Path relative to the folder -> key of its bytes.
};

struct JobRecord {
  std::string key;  ///< The plan's; "" = there is no record.
  std::vector<JobDependency> depends_on;
  std::map<std::string, DoneItem> items;
  std::map<std::string, std::string> joined = {};   ///< Joined as DoneItem::files, of the files that no item made.
  std::map<std::string, std::uint64_t> bytes = {};  ///< Size of every file; empty in folders of earlier versions.
};

/// The record of a folder; an empty one when it has none, it is damaged, or it belongs to another manifest.
/// @param key  The manifest's.
[[nodiscard]] JobRecord read_job_record(const std::filesystem::path& folder, const std::string& key);
/// Adds what the folder holds now to the record: sizes, and keys of the files that no item made.
/// @param manifest  Is left out: it may say where inputs lie. @throws CannotComplete
void write_job_record(const std::filesystem::path& folder, JobRecord record, const std::string& manifest = "");

/// Files of a finished folder that are not what the record says, each in their order.
struct FolderDamage {
  std::vector<std::string> lost;
  std::vector<std::string> altered;
  [[nodiscard]] bool any() const { return !lost.empty() || !altered.empty(); }
};
enum class Looked { AtSizes, AtContent };
/// @param looked  AtContent reads every file. Throws nothing: what cannot be read is altered.
[[nodiscard]] FolderDamage damage_of(const std::filesystem::path& folder, const JobRecord& record, Looked looked);

/// Files of the item, as `done` says: all of its outputs and some optional ones; nothing if that is not what it
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
