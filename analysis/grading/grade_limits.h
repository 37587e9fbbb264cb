/// \file
/// What a coating has to keep to: a text file with a limit a line, such as `Ri <= 2 at 480 h`.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/grading/grade_rules.h"
#include "analysis/grading/graded_surface.h"
#include "patinate/history/history_value.h"

namespace patinate::analysis {

/// One line: `NAME <= VALUE at TIME UNIT` or `>=`. NAME is a scale or a figure; `gloss_60 retention` and `gloss
/// retention` are percent of the unexposed surface's.
struct GradeLimit {
  std::string text;       ///< Text as it was written.
  std::string name = {};  ///< Scale or figure.
  bool is_retention = false;
  bool is_at_most = true;
  double value = 0.0;
  double time = 0.0;  ///< In the history's unit.
};

enum class LimitState {
  Pass,
  Fail,
  Undecided,  ///< The interval holds the limit.
  NotTested   ///< The figure is not known at that time.
};
inline constexpr std::array<std::string_view, 4> kLimitStateNames{"pass", "fail", "undecided", "not tested"};

struct LimitResult {
  GradeLimit limit;
  std::string region;
  LimitState state = LimitState::Undecided;
  std::string found = {};  ///< "2 (1 to 2)"; why, where it is undecided.
};

/// Blank lines and what follows `#` are passed over. @throws IoError naming the line, with a did-you-mean.
[[nodiscard]] std::vector<GradeLimit> read_grade_limits(const std::filesystem::path& file, const GradeRules& rules,
                                                        TimeUnit unit);
/// For every region, in the order of the limits.
[[nodiscard]] std::vector<LimitResult> check_limits(const std::vector<GradeLimit>& limits, const GradedSurface& surface,
                                                    const GradeRules& rules);

}  // namespace patinate::analysis
