/// \file
/// What a scene will have done by its end, in seconds: a coarse run in place of the whole one.
#pragma once

#include <cstdint>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/simulation/scene_io.h"
#include "simulation/job/outcome.h"

namespace patinate::simulation {

struct RunEstimate {
  std::vector<ObjectOutcome> outcome;
  int resolution = 0;          ///< At which it was made.
  std::int64_t gammatons = 0;  ///< Under way at a time, where the scene has all_gammatons.
  std::int64_t all_gammatons = 0;
};

/// Runs the scene to its end on an atlas of at most 192 texels a side, with its gammatons (or as many a texel, where
/// what they carry is counted in texels), and where that is much, with fewer that carry more. Means and shares come out
/// as those of the whole run but for what a coarse grid hides: thin runs, and how much a contact takes where little is
/// left. Same bits for any number of threads. @throws as Simulation; Canceled.
[[nodiscard]] RunEstimate estimate_run(SceneFile file, const SimulationOptions& options,
                                       const RunControl& control = {});

}  // namespace patinate::simulation
