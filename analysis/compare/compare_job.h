/// \file
/// A comparison as a job: `report.html`, `report.json` and a CSV of every curve.
#pragma once

#include <filesystem>
#include <string>

#include "analysis/figures/compared_pair.h"
#include "libcommon/job/job.h"

namespace patinate::analysis {

inline constexpr const char* kCompareReportFile = "report.json";
inline constexpr const char* kCompareTableFile = "figures.csv";
inline constexpr const char* kComparePageFile = "report.html";

struct CompareTask {
  std::filesystem::path a, b;     ///< Histories or transfers.
  std::filesystem::path through;  ///< A transfer that A is looked up through; "" = none.
  CompareOptions options;
  std::string command;  ///< Command that repeats it, for the report; no part of the key.
};

/// Opens both sides at once. @throws InvalidInput, IoError.
[[nodiscard]] JobPlan plan_compare(CompareTask task, const std::filesystem::path& output);

}  // namespace patinate::analysis
