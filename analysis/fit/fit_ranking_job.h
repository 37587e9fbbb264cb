/// \file
/// A ranking of fits as a report: report.html, report.json, ranking.csv.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/job/job.h"

namespace patinate::analysis {

inline constexpr const char* kRankingReportFile = "report.json";
inline constexpr const char* kRankingPageFile = "report.html";
inline constexpr const char* kRankingTableFile = "ranking.csv";

struct RankingTask {
  std::vector<std::filesystem::path> fits;  ///< Folders of finished fits, two or more.
  std::vector<std::string> names;           ///< One a fit, as it was given; unique.
  std::string command;                      ///< What repeats it, for the report; no part of the key.
};

/// @throws InvalidInput as rank_fits() does; IoError.
[[nodiscard]] JobPlan plan_ranking(RankingTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
