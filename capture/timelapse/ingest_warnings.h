/// \file
/// What an ingest found that may make its history wrong, as the history's own warnings.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/timelapse/repair.h"
#include "patinate/history/history_value.h"

namespace patinate::capture {

/// Warnings about the survey's findings, one a kind: photographs that cannot be laid over the others, and those that
/// are moved, exposed differently or do not follow, unless they were repaired.
/// @param num_frames  Of the history; >= 1. @param is_aligned  They were laid over one another by `align`.
[[nodiscard]] std::vector<HistoryWarning> survey_warnings(const SurveyReport& survey, int num_frames, bool is_aligned);

/// "a.jpg, b.jpg, c.jpg and 5 more", or "copper.webp, images 3, 4, 9 and 5 more". @param most  As many are named; >= 1.
[[nodiscard]] std::string photo_list(const std::vector<std::string>& photos, std::size_t most = 4);

/// For people: to two decimals.
[[nodiscard]] std::string hundredths(double v);

}  // namespace patinate::capture
