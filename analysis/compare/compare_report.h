/// \file
/// A comparison for people and for programs.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "analysis/figures/compared_pair.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

struct CompareProvenance {
  const SeriesFile& a;
  const SeriesFile& b;
  const CompareOptions& options;
  std::string command;
  std::string key;
};

/// "5 frames, 0 to 480 min".
[[nodiscard]] std::string times_text(const HistoryFacts& facts);
/// What a report says of a side.
[[nodiscard]] Json side_json(const SeriesFile& side);

/// Writes report.html (everything inside), report.json, figures.csv and curves/<name>.csv.
/// @param sections  With a `source` in every picture. @throws CannotComplete; InvalidInput if a number is not finite.
void write_compare_report(const std::filesystem::path& folder, const CompareProvenance& provenance,
                          std::span<const Section> sections);

}  // namespace patinate::analysis
