/// \file
/// Where on a captured surface the colors are that a simulated one does not have.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/figures/compared_pair.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

/// Name of the section with the pictures.
inline constexpr const char* kMisfitSection = "misfit";

/// How far each place's color is moved when the distribution of colors becomes the other one's, at some of the times.
struct MisfitMaps {
  std::vector<double> times = {};  ///< Times of the pair's clock.
  std::vector<ImageF> moves = {};  ///< Delta E 1976 (sliced_moves()), at the captured surface's pixels.
  ImageU8 mask = {};
  std::string time_unit = {};
};
/// Maps of A, up to five times. Cost: that of five sliced distances.
[[nodiscard]] MisfitMaps misfit_maps(const ComparedPair& pair, const RunControl& control = {});

/// The maps with the starting and with the best values, at one scale: that of the 95th percentile before, 2 at least.
[[nodiscard]] std::vector<Picture> misfit_pictures(const MisfitMaps& before, const MisfitMaps& after);

}  // namespace patinate::analysis
