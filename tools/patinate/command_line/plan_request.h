/// \file
/// What `plan`, `run` and `join` ask of a command in place of carrying it out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/job/job.h"

namespace patinate::cli {

/// A piece of a command's work that can be done by itself.
struct PlannedItem {
  std::string name;
  std::string key;                             ///< Key of all that it depends on.
  std::vector<std::filesystem::path> outputs;  ///< Outputs as they are called in the end.
  std::vector<std::size_t> waits_for;          ///< Items that have to be finished before.
  double weight = 1.0;                         ///< Its share of the work, against the others.
  bool is_finished = false;
  std::vector<std::string> inputs = {};  ///< Inputs as JobItem's.
};

/// A command's work as data.
struct PlannedWork {
  std::filesystem::path output;
  std::string key;                        ///< Key of all that it depends on.
  std::vector<JobDependency> depends_on;  ///< Inputs of the key, as far as they are known.
  std::vector<PlannedItem> items;
  bool has_join = false;     ///< The output is made of the items by `join`; else each makes files of the output.
  double join_weight = 0.0;  ///< Against the items'.
  bool is_up_to_date = false;

  [[nodiscard]] std::vector<std::size_t> unfinished() const;
};

/// A plan file, as far as a command looks at it.
struct PlanIdentity {
  std::filesystem::path file;
  std::string key;
  std::vector<JobDependency> depends_on;
};

/// Request to a command, and its answer.
struct PlanRequest {
  enum class Wanted {
    Description,  ///< Nothing is made.
    Items,        ///< Some items are run.
    Join,         ///< The output is made of finished items.
    Whole,        ///< Items and join, without locks: others may do the same elsewhere.
  } wanted = Wanted::Description;
  std::optional<PlanIdentity> identity = {};  ///< The work has to be this plan's.
  std::string items = "";                     ///< "0-3,7"; "" = all.
  std::optional<PlannedWork> work = {};       ///< The answer to Description.
};

/// @throws InvalidInput naming what has changed unless `work` is what the plan file was made for.
void require_same_work(const PlanIdentity& identity, const std::string& key,
                       const std::vector<JobDependency>& depends_on);
/// The plan's items as they stand. @throws as spread_state().
[[nodiscard]] PlannedWork planned_work(const JobPlan& plan);
/// @throws CannotComplete naming the items that are not finished.
void require_finished(const PlannedWork& work);
/// The items that are asked for. @throws UsageError
[[nodiscard]] std::vector<std::size_t> asked_items(const PlanRequest& request, std::size_t num_items);

}  // namespace patinate::cli
