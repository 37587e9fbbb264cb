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

/// Content of explanation.json that others need.
struct ExplanationManifest {
  struct Candidate {
    std::string name;
    std::optional<double> correlation;  ///< None where it is the same everywhere.
    std::optional<double> corrected_p;
  };
  std::string reference, mesh, verdict;
  std::vector<Candidate> candidates;  ///< The strongest first.
  std::string mix;                    ///< Mix as `transfer` takes it; "" where there is none.
  std::string key;
};
/// @param path  The folder or its kExplanationFile. @throws IoError
[[nodiscard]] ExplanationManifest read_explanation(const std::filesystem::path& path);

/// Writes kExplanationFile, kExplanationTableFile and kExplanationPageFile. @throws CannotComplete
void write_explanation(const std::filesystem::path& folder, const ExplanationReport& report, const RunControl& control);

}  // namespace patinate::analysis
