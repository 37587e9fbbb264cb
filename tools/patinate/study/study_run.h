/// \file
/// A study on this machine.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "patinate/core/run_control.h"
#include "tools/patinate/study/study_folder.h"

namespace patinate::cli {

struct StudyOutcome {
  std::size_t num_done = 0;           ///< Steps.
  std::vector<std::string> failures;  ///< A line each: "CELL: STEP: ...".
};

/// Runs every step of every cell as a process of its own, in the study's folder; `num_jobs` at a time. Steps that are
/// done say so themselves, since only they know all that they depend on. After a step that fails the cell's others are
/// left out, and the other cells go on.
/// @param control  Its threads are shared by the processes. @throws CannotComplete if none can be started; Canceled.
[[nodiscard]] StudyOutcome run_study(const StudyFolder& study, int num_jobs, const RunControl& control);

}  // namespace patinate::cli
