/// \file
/// What stands where a plan's output is to be, seen without touching it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/job/job.h"
#include "libcommon/job/job_record.h"

namespace patinate {

enum class FoundOutput { Nothing, Same, Different };

struct OutputState {
  std::filesystem::path output;  ///< Without a slash at its end.
  FoundOutput found = FoundOutput::Nothing;
  JobRecord record;                ///< Record of a Different output; empty when it has none.
  std::vector<JobChange> changes;  ///< Why it is different, as far as it is recorded.
  bool only_grows = false;         ///< The plan may grow, and nothing but additions was found.
  /// Damage of an output that was made from the same: it counts as Different, and as replaceable where nothing
  /// but losses was found.
  FolderDamage damage = {};
  bool is_made_again = false;  ///< The output is up to date, and `force` asks for it.
};

/// @throws CannotComplete if the folder's parent is missing, or something is there that patinate did not make from such
/// a plan.
[[nodiscard]] OutputState look_at_output(const JobPlan& plan);
/// Looks in the same way, but with `force` a Same output counts as Different, of which nothing is kept.
[[nodiscard]] OutputState look_at_output(const JobPlan& plan, const JobOptions& options);
/// @throws CannotComplete if the output is different and neither grows nor is to be replaced.
void require_replaceable(const OutputState& state, const JobOptions& options);
/// The item's own key, or the plan's.
[[nodiscard]] const std::string& item_key(const JobPlan& plan, const JobItem& item);
/// Files in a finished folder of an item that need not be made again; nullptr when it must be. Files are not looked
/// at.
[[nodiscard]] const DoneItem* reusable_item(const OutputState& state, const JobItem& item);

}  // namespace patinate
