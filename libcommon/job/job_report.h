/// \file
/// Dry run: what a plan would do, and why. Reads, and touches nothing.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/job/job.h"
#include "libcommon/job/job_record.h"
#include "patinate/core/json.h"

namespace patinate {

enum class OutputNeed {
  UpToDate,  ///< Nothing would be done.
  Missing,   ///< The output would be made.
  Grown,     ///< The output would be made again with what was added; nothing in it is lost.
  Stale,     ///< It was made from other input or options: replaced with `force`, else untouched.
};

/// Treatment of one item.
enum class ItemNeed {
  Run,
  Resume,  ///< Finished by an interrupted run.
  Reuse,   ///< Taken over from the finished output.
};

struct JobReport {
  std::filesystem::path output;
  OutputNeed need = OutputNeed::Missing;
  bool is_forced = false;
  bool is_made_again = false;      ///< It is up to date, and forced.
  std::vector<JobChange> changes;  ///< Why a Grown or Stale output is so, as far as it says what it was made from.
  FolderDamage damage;             ///< Why a Missing or Stale output is so that was made from the same.
  struct Item {
    std::string name;
    ItemNeed need = ItemNeed::Run;
  };
  std::vector<Item> items;  ///< Items of what would be done; empty for single files and when nothing would.

  /// The command would end with "give --force".
  [[nodiscard]] bool needs_force() const { return need == OutputNeed::Stale && !is_forced; }
  /// Why, a line each.
  [[nodiscard]] std::vector<std::string> reasons() const;
  /// Several lines without an end of line.
  [[nodiscard]] std::string text() const;
  /// Members output, dry_run (true), would (nothing, make, grow, replace), needs_force, reasons, changes, items.
  [[nodiscard]] Json json() const;
};

/// Predicts run_job(). Outputs that could be reused are read, because only unchanged ones are.
/// @throws what run_job() throws before it begins, but for a need of `force`, and but for a folder in use.
[[nodiscard]] JobReport explain_job(const JobPlan& plan, const JobOptions& options);
/// Predicts check_output_files(). @throws as it does, but for a need of `force`.
[[nodiscard]] JobReport explain_output_files(const std::vector<OutputFile>& files, const std::string& key,
                                             const JobOptions& options);

}  // namespace patinate
