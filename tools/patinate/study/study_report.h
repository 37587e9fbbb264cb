/// \file
/// One page on a study: pictures, figures, and what failed.
#pragma once

#include <cstddef>

#include "patinate/core/run_control.h"
#include "tools/patinate/study/study_folder.h"

namespace patinate::cli {

struct StudyReport {
  std::size_t num_done = 0;  ///< Cells, of which every step is done.
  std::size_t num_failed = 0;
  std::size_t num_open = 0;  ///< Not run, or not to the end.
};

/// Writes `report.html`, `report.json` and for each part `PART.csv` into a study's folder. Equal results give equal
/// bytes, whoever ran the steps.
/// @throws CannotComplete; Canceled.
StudyReport write_study_report(const StudyFolder& study, const RunControl& control);

}  // namespace patinate::cli
