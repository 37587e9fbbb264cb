/// \file
/// Grades of several panels that were coated and exposed alike, and of two such groups.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "analysis/grading/grade_job.h"

namespace patinate::analysis {

struct GradeGroupsTask {
  std::vector<GradeTask> a;        ///< Two or more.
  std::vector<GradeTask> b = {};   ///< Empty: A alone is described; else two or more.
  std::vector<std::string> names;  ///< Names on the page: those of A, then those of B.
  std::uint64_t seed = 0;          ///< Of relabelings, where there are too many for all of them.
  std::string command = {};        ///< Command that repeats it, for the report; no part of the key.
};

/// A job that writes `report.html`, `report.json` and `figures.csv`, and in `panels/1`, `panels/2`, ... the report of
/// each panel. Figures are compared at the last time that every panel has, by the permutation test of
/// compare_replicates(). Every panel is an item with a key of its own. Opens all of them at once.
/// @throws InvalidInput if a group has one panel, two panels are the same history, or they have no time in common;
/// IoError.
[[nodiscard]] JobPlan plan_grade_groups(GradeGroupsTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
