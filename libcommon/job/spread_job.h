/// \file
/// A plan whose items run anywhere, in any process on any machine that shares a file system, and in any order that
/// their stages allow: what run_job() does in one process, and the same bytes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "libcommon/job/job.h"

namespace patinate {

/// How far a plan has come.
struct SpreadState {
  bool is_up_to_date = false;     ///< The output is there, and is this plan's.
  std::vector<bool> is_finished;  ///< Every item; all of them when up to date.
};
/// @throws CannotComplete as run_job() before it begins, but for a need of `force`.
[[nodiscard]] SpreadState spread_state(const JobPlan& plan);

/// Indices of the items that have to be finished before this one runs: those of earlier stages.
[[nodiscard]] std::vector<std::size_t> waits_for(const JobPlan& plan, std::size_t item);

/// Runs items and keeps each in `OUT.items` when it is finished (item_store.h). Those that are finished already are not
/// run again; two processes that run the same item at once both end well, and one result is kept. Uses no locks.
/// @param items  Indices into plan.items, in any order.
/// @returns how many were run.
/// @throws CannotComplete naming the items that have to be finished before one of these; as run_job(); Canceled.
std::size_t run_spread_items(const JobPlan& plan, std::span<const std::size_t> items, const JobOptions& options,
                             const RunControl& control);

/// Makes the output of finished items, by one rename, and removes `OUT.items`. Two processes may do it at once.
/// @throws CannotComplete naming the items that are missing; as run_job(); Canceled.
JobStatus join_spread_items(const JobPlan& plan, const JobOptions& options, const RunControl& control);

/// Message of a join that lacks items.
[[nodiscard]] std::string unfinished_text(const std::filesystem::path& output, std::span<const std::size_t> missing,
                                          std::size_t num_items);
/// "0-3, 7" for {0, 1, 2, 3, 7}; ascending.
[[nodiscard]] std::string item_ranges_text(std::span<const std::size_t> items);
/// The reverse, ascending and each once. @throws ParseError naming what was found and the items [0, num_items) there
/// are.
[[nodiscard]] std::vector<std::size_t> parse_item_ranges(const std::string& text, std::size_t num_items);

}  // namespace patinate
