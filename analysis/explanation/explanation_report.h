/// \file
/// What explain() has found, for people and for programs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/explanation/explanation_job.h"
#include "analysis/report/report_page.h"

namespace patinate::analysis {

/// A control map that an item has made, or why it could not.
struct MadeControl {
  std::string name;
  ControlMap map;
  std::string problem;  ///< "" = there is a map.
};

struct ExplanationReport {
  const ExplanationTask& task;
  const Explanation& found;
  const ExplanationInput& input;
  const std::vector<MadeControl>& controls;  ///< Controls as ExplanationInput::candidates.
  const std::vector<MadeControl>& skipped;
  std::string key;
};

/// The reference, the strongest controls and the mix on the mesh, seen from two sides. @param scratch  A file that is
/// written and removed. @throws CannotComplete
[[nodiscard]] std::vector<Picture> explanation_pictures(const ExplanationReport& report,
                                                        const std::filesystem::path& scratch,
                                                        const RunControl& control);

/// "`height` explains it: ..." or that nothing does: one sentence.
[[nodiscard]] std::string verdict_text(const Explanation& found);

/// explanation.json.
struct ExplanationManifest {
  struct Candidate {
    ExplainedCandidate found;
    std::string unit;
    double low = 0.0, high = 0.0;  ///< Values that 0 and 1 stand for.
  };
  struct Member {
    std::string name;
    MixMember found;
  };
  struct ListedMix {
    std::string argument;  ///< As `transfer` takes it.
    std::vector<Member> members;
    ExplainedMix found;
  };
  std::string reference, about, mesh, verdict;
  std::vector<std::string> notes;
  std::size_t num_places = 0;
  double area_mm2 = 0.0;
  Explanation found;                                         ///< Numbers of blocks alone.
  std::vector<Candidate> candidates;                         ///< The strongest first.
  std::vector<std::pair<std::string, std::string>> skipped;  ///< Kinds without a map, and why.
  std::optional<ListedMix> mix;
  ReportOrigin origin;
};
/// @param path  The folder or its kExplanationFile. @throws IoError
[[nodiscard]] ExplanationManifest read_explanation(const std::filesystem::path& path);

/// Writes kExplanationFile, kExplanationTableFile and kExplanationPageFile. @throws CannotComplete
void write_explanation(const std::filesystem::path& folder, const ExplanationReport& report, const RunControl& control);

}  // namespace patinate::analysis
