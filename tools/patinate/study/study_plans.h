/// \file
/// Plans of a study's steps that Snakemake runs item by item.
#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "tools/patinate/study/study_folder.h"

namespace patinate::cli {

/// Makes `plans/STEP/CELL.json` for every cell of a step that goes in items. Where a plan is not what it was, what said
/// that its items are done (`items/STEP/CELL`, `done/STEP/CELL`) is removed.
/// @returns what is wrong with cells, a line each. @throws CannotComplete; Canceled
[[nodiscard]] std::vector<std::string> write_plans(const StudyFolder& study, const std::stop_token& stop);

}  // namespace patinate::cli
