/// \file
/// Charts of a fit's page, as SVG.
#pragma once

#include <span>
#include <string>

#include "analysis/fit/fit_report.h"

namespace patinate::analysis {

/// The objective over the evaluations of the search.
[[nodiscard]] std::string search_chart(const FitOutcome& o);
/// States what is off before anything has aged, "" where the starting and the best values differ in it or nothing is.
[[nodiscard]] std::string start_text(const std::string& name, std::span<const Section> before,
                                     std::span<const Section> after);
/// A curve of the comparison with the starting and with the best values; empty where that is not told over time.
[[nodiscard]] std::string misfit_chart(const std::string& name, std::span<const Section> before,
                                       std::span<const Section> after);
/// The objective along a parameter that was examined. @param i  Its index.
[[nodiscard]] std::string scan_chart(const FitTask& task, const FitOutcome& o, std::size_t i);

}  // namespace patinate::analysis
