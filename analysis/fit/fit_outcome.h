/// \file
/// What the finished evaluations of a fit come to.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "analysis/fit/fit_work.h"

namespace patinate::analysis {

/// Writes all files of plan_fit() but the evaluations, which lie in the folder. @param key  Of the plan. @throws
/// CannotComplete; IoError.
void join_fit(FitWork& work, const std::filesystem::path& folder, const std::string& key, const RunControl& control);

/// The last frame up to `until`, held: what any model has to be better than. @param held_out  Of the frames after it.
[[nodiscard]] std::optional<double> last_frame_held(const FitObjective& held_out, const std::filesystem::path& history,
                                                    double until, const RunControl& control);

}  // namespace patinate::analysis
