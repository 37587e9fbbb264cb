/// \file
/// A fit and what it reports.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <utility>

#include "analysis/fit/fit_job.h"
#include "libcommon/core/files.h"
#include "libcommon/job/job.h"

namespace patinate::testing_support {

inline Json run_fit(analysis::FitTask task, const std::filesystem::path& output, int num_threads = 0,
                    std::stop_token stop = {}) {
  RunControl control;
  control.num_threads = num_threads;
  control.stop = std::move(stop);
  (void)run_job(analysis::plan_fit(std::move(task), output), {.force = true}, control);
  return load_json(output / analysis::kFitReportFile);
}

}  // namespace patinate::testing_support
