/// \file
/// A comparison for people and for programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

/// Writes report.html (everything inside), report.json and curves/<name>.csv.
/// @param sections  section_json() with a `source` in every picture. @throws CannotComplete
void write_compare_report(const std::filesystem::path& folder, const CompareProvenance& provenance,
                          const std::vector<Json>& sections);

}  // namespace patinate::analysis
