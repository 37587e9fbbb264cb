#include "tools/patinate/command_line/plan_request.h"

#include <algorithm>
#include <numeric>

#include "app/request/usage_error.h"
#include "libcommon/job/job_record.h"
#include "libcommon/job/output_state.h"
#include "libcommon/job/spread_job.h"
#include "patinate/core/error.h"

namespace patinate::cli {

std::vector<std::size_t> PlannedWork::unfinished() const {
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!items[i].is_finished) list.push_back(i);
  }
  return list;
}

void require_same_work(const PlanIdentity& identity, const std::string& key,
                       const std::vector<JobDependency>& depends_on) {
  if (identity.key == key) return;
  std::string what = "the inputs are not what they were";
  const std::vector<JobChange> changes = changes_between(identity.depends_on, depends_on);
  if (!changes.empty()) {
    // Missing parts change what comes after them.
    const auto gone = std::find_if(changes.begin(), changes.end(),
                                   [](const JobChange& c) { return c.kind == JobChange::Kind::Removed; });
    const JobChange& told = gone == changes.end() ? changes.front() : *gone;
    what = told.name + (told.kind == JobChange::Kind::Added     ? " is new"
                        : told.kind == JobChange::Kind::Removed ? " is gone"
                                                                : " has changed");
    if (changes.size() > 1) what += " and " + std::to_string(changes.size() - 1) + " more";
  }
  throw InvalidInput(identity.file.string() + ": was made for other input (" + what + "); make the plan again");
}

PlannedWork planned_work(const JobPlan& plan) {
  const SpreadState state = spread_state(plan);
  PlannedWork work;
  work.output = plan.output;
  work.key = plan.key;
  work.depends_on = plan.depends_on;
  work.has_join = true;
  work.join_weight = plan.join_weight;
  work.is_up_to_date = state.is_up_to_date;
  for (std::size_t i = 0; i < plan.items.size(); ++i) {
    const JobItem& item = plan.items[i];
    work.items.push_back({.name = item.name,
                          .key = item_key(plan, item),
                          .outputs = item.outputs,
                          .waits_for = waits_for(plan, i),
                          .weight = item.weight,
                          .is_finished = state.is_finished[i],
                          .inputs = item.inputs});
  }
  return work;
}

void require_finished(const PlannedWork& work) {
  const std::vector<std::size_t> missing = work.unfinished();
  if (!missing.empty()) throw CannotComplete(unfinished_text(work.output, missing, work.items.size()));
}

std::vector<std::size_t> asked_items(const PlanRequest& request, std::size_t num_items) {
  if (request.items.empty()) {
    std::vector<std::size_t> all(num_items);
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }
  if (num_items == 0)
    throw app::UsageError("--items: the plan has no items; `patinate cluster join` does all of its work");
  try {
    return parse_item_ranges(request.items, num_items);
  } catch (const ParseError& e) {
    throw app::UsageError("--items: " + std::string(e.what()));
  }
}

}  // namespace patinate::cli
