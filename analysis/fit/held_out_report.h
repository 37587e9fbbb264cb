/// \file
/// What a fit says of the frames that its search did not see, for people and for programs.
#pragma once

#include <optional>

#include "analysis/fit/fit_job.h"
#include "analysis/fit/fit_report.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

/// "4 d": a time of the history with its unit, where that is known.
[[nodiscard]] std::string until_text(double until, const std::string& time_unit);

/// Nothing without frames held out.
void add_held_out(HtmlPage& page, const FitTask& task, const FitOutcome& outcome);
/// null without frames held out.
[[nodiscard]] Json held_out_json(const FitTask& task, const FitOutcome& outcome);
/// The inverse, as far as others need it. @throws IoError
[[nodiscard]] std::optional<HeldOutFrames> read_held_out(JsonReader json);

}  // namespace patinate::analysis
