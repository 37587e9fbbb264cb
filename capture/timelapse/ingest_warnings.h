/// \file
/// What an ingest found that may make its history wrong, as the history's own warnings.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/timelapse/repair.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// Share of the pixels from where on a mask is warned of: what is left may not stand for the surface.
inline constexpr double kMuchMasked = 0.2;

/// Of what the survey found: photographs that are moved, exposed differently or do not follow, unless they were
/// repaired; and how much of the picture no mask leaves.
/// @param num_frames  Of the history; >= 1.
[[nodiscard]] std::vector<HistoryWarning> survey_warnings(const SurveyReport& survey, int num_frames);

/// "a.jpg, b.jpg, c.jpg and 5 more". @param most  As many are named; >= 1.
[[nodiscard]] std::string photo_list(const std::vector<std::string>& photos, std::size_t most = 4);

}  // namespace patinate::capture
