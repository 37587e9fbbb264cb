/// \file
/// What a fit says of the frames that its search did not see, for people and for programs.
#pragma once

#include "analysis/fit/fit_job.h"
#include "analysis/fit/fit_report.h"
#include "libcommon/output/html_page.h"

namespace patinate::analysis {

/// "4 d": a time of the history with its unit, where that is known.
[[nodiscard]] std::string until_text(double until, const std::string& time_unit);

/// Nothing without frames held out.
void add_held_out(HtmlPage& page, const FitTask& task, const FitOutcome& outcome);
}  // namespace patinate::analysis
