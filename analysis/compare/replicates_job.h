/// \file
/// A comparison of replicates as a job: `report.html`, `report.json`, `figures.csv`, `distances.csv`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/job/job.h"
#include "patinate/analysis/compare_options.h"

namespace patinate::analysis {

inline constexpr const char* kReplicateDistancesFile = "distances.csv";

struct ReplicatesTask {
  std::vector<std::filesystem::path> a, b;  ///< Histories or transfers; two or more each.
  std::vector<std::string> names;           ///< Names on the page: those of A, then those of B.
  CompareOptions options;
  std::string command;  ///< Command that repeats it, for the report; no part of the key.
};

/// Every pair is an item with a key of its own: what is added later leaves finished pairs as they are, as long as the
/// common times stay. Opens all of them at once.
/// @throws InvalidInput if a side has fewer than two, two have equal content, those of a side differ in size, or they
/// have no time in common; IoError.
[[nodiscard]] JobPlan plan_replicates(ReplicatesTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
