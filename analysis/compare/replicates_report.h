/// \file
/// A comparison of replicates for people and for programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/compare/replicates.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

struct ReplicatesProvenance {
  const std::vector<SeriesFile>& files;  ///< Those of A first.
  const std::vector<std::string>& names;
  const std::vector<double>& clock;
  std::vector<std::string> warnings;
  const CompareOptions& options;
  std::string command;
  std::string key;
};

/// Conclusions from the p values, a sentence each.
[[nodiscard]] std::vector<std::string> replicate_verdict(const ReplicateComparison& comparison);

/// With a capital and a period. @param conclusion  One of replicate_verdict(), not empty.
[[nodiscard]] std::string verdict_sentence(std::string conclusion);

/// Writes report.html (everything inside), report.json, figures.csv and distances.csv.
/// @param look  Every picture must have a `source`. @throws CannotComplete; InvalidInput if a number is not finite.
void write_replicates_report(const std::filesystem::path& folder, const ReplicatesProvenance& provenance,
                             const ReplicateComparison& comparison, const Section& look);

}  // namespace patinate::analysis
