/// \file
/// What the finished evaluations of a fit come to.
#pragma once

#include <filesystem>
#include <string>

#include "analysis/fit/fit_work.h"

namespace patinate::analysis {

/// Writes all files of plan_fit() but the evaluations, which lie in the folder. @param key  Of the plan. @throws
/// CannotComplete; IoError.
void join_fit(FitWork& work, const std::filesystem::path& folder, const std::string& key, const RunControl& control);

}  // namespace patinate::analysis
