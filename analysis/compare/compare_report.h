/// \file
/// A comparison for people and for programs.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "analysis/figures/compared_pair.h"
#include "libcommon/document/document.h"
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
/// Facts of a side that a report states.
struct ComparedSide {
  std::string name, origin;
  int width = 0, height = 0;
  std::int64_t num_frames = 0;
  double first_time = 0.0, last_time = 0.0;
  TimeUnit time_unit = TimeUnit::Seconds;
  std::optional<double> texel_size_mm;
  std::vector<ControlFacts> controls;
  std::vector<HistoryWarning> warnings;
  std::string key;
};
void describe(DocumentVisitor& v, ComparedSide& side);
[[nodiscard]] ComparedSide side_of(const SeriesFile& side);

/// Writes report.html (everything inside), report.json, figures.csv and curves/<name>.csv.
/// @param sections  Every picture must have a `source`. @throws CannotComplete; InvalidInput if a number is not finite.
void write_compare_report(const std::filesystem::path& folder, const CompareProvenance& provenance,
                          std::span<const Section> sections);

}  // namespace patinate::analysis
