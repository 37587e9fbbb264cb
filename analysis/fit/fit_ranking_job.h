/// \file
/// A ranking of fits as a report: report.html, report.json, ranking.csv.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "analysis/fit/fit_ranking.h"
#include "libcommon/job/job.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

inline constexpr const char* kRankingReportFile = "report.json";
inline constexpr const char* kRankingPageFile = "report.html";
inline constexpr const char* kRankingTableFile = "ranking.csv";

struct RankingTask {
  std::vector<std::filesystem::path> fits;  ///< Folders of finished fits, two or more.
  std::vector<std::string> names;           ///< One a fit, as it was given; unique.
  std::string command;                      ///< Command that repeats it, for the report; no part of the key.
};

/// Reads the input of rank_fits(). @param fits  Folders of finished fits. @param names  One a fit. @throws IoError
[[nodiscard]] std::vector<RankedFit> read_ranked_fits(const std::vector<std::filesystem::path>& fits,
                                                      const std::vector<std::string>& names);
/// Members unit, models, cases, last_frame and verdict of report.json (docs/schema/ranking.schema.json).
[[nodiscard]] Json ranking_json(const Ranking& ranking, std::span<const RankedFit> fits);

/// @throws InvalidInput as rank_fits() does; IoError.
[[nodiscard]] JobPlan plan_ranking(RankingTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
