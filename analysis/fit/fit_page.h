/// \file
/// report.html of a fit: what a person reads.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/fit/fit_report.h"

namespace patinate::analysis {

/// A verdict in plain words: "not determined: no figure changes anywhere in its range". @param index  Of the parameter.
[[nodiscard]] std::string verdict_text(const FitTask& task, const FitOutcome& outcome, std::size_t index);

/// Writes it, everything inside, and its drawings as files of their own: curves/search.svg, misfit.svg and
/// along_rules_0_rate.svg for each number that was examined; with several captures misfit_2.svg and along_..._2.svg are
/// the second's. @param captures, changes  One each. @throws CannotComplete
void write_fit_page(const std::filesystem::path& folder, const std::string& title, const FitTask& task,
                    const FitOutcome& outcome, std::span<const CaptureSections> captures,
                    std::span<const std::vector<FigureChange>> changes);

}  // namespace patinate::analysis
