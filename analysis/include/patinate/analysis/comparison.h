/// \file
/// A comparison in one call, without files: what is said about two surfaces that age.
#pragma once

#include <vector>

#include "patinate/analysis/compare_options.h"
#include "patinate/analysis/report_parts.h"
#include "patinate/analysis/texture_series.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// Sections `look`, `places`, `colors`, `controls`, `structure`, and `cracks` when asked for (docs/compare.md): their
/// figures with intervals, curves and pictures. What is not defined for these surfaces says why.
/// @throws InvalidInput if an option is out of range or the surfaces have no time in common; IoError.
/// Cost: two frames read for each time and side; num_resamples evaluations of the figures. Same bits for any number of
/// threads.
[[nodiscard]] std::vector<Section> compare(TextureSeries a, TextureSeries b, const CompareOptions& options = {},
                                           const RunControl& control = {});

}  // namespace patinate::analysis
