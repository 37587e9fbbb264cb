/// \file
/// What a fit found, for people and for programs.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "analysis/fit/determined.h"
#include "analysis/fit/fit_job.h"
#include "analysis/fit/fit_record.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

struct FitOutcome {
  std::vector<FitEvaluation> searched;  ///< In order; those that were skipped have no points.
  FitPoint initial, best;
  int num_planned = 0;
  bool is_converged = false;
  std::optional<double> lately_gained;  ///< MultiStart::lately_gained(), where a number of the aging is searched.
  std::vector<FitEvaluation> seeds;     ///< The best with other seeds.
  std::vector<double> chances;          ///< Chance of the objective, at the best and near it.
  double threshold = 0.0;               ///< Differences of the objective up to here mean nothing.
  BoxScans scans;                       ///< Along every parameter, the others as at the best.
  BoxScans profiles;                    ///< Scans in which the others move to make up for it.
  std::vector<ParameterVerdict> verdicts;
  std::optional<Valley> valley;
  std::string no_valley;            ///< Why there is none.
  std::optional<HeldOut> held_out;  ///< With ObjectiveOptions::until.
};

/// Sections of a comparison of a capture with the starting and with the best values: sections with a `source` in every
/// picture, the first of them the look.
struct CaptureSections {
  std::vector<Section> before, after;
};

/// "open, shaded and dry".
[[nodiscard]] std::string captures_text(const FitTask& task);

/// Simulations that the search made, and appearances of them.
[[nodiscard]] int count_agings(const FitOutcome& outcome);
[[nodiscard]] int count_points(const FitOutcome& outcome);

/// Writes report.html (everything inside), report.json and evaluations.csv. @param captures  One each. @throws
/// CannotComplete
void write_fit_report(const std::filesystem::path& folder, const FitTask& task, const FitOutcome& outcome,
                      std::span<const CaptureSections> captures, const std::string& key);

}  // namespace patinate::analysis
