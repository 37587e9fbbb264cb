/// \file
/// Every combination of what a study varies, as its cells.
#pragma once

#include <string>
#include <vector>

#include "tools/patinate/study/study.h"
#include "tools/patinate/study/study_ranges.h"

namespace patinate::cli {

/// Adds every combination of levels to `part`. @param factors  The first holds the inputs; none is empty.
/// @param step_words  Of every step but the first, what stands behind its subject.
/// @returns what is wrong, a line each: two cells in one place, too many cells.
[[nodiscard]] std::vector<std::string> make_cells(const std::vector<std::vector<StudyLevel>>& factors,
                                                  const std::vector<std::vector<std::string>>& step_words,
                                                  StudyPart& part);

}  // namespace patinate::cli
