/// \file
/// Whether a texture keeps the lines of its source: cracks, veins, rims. Measured in pictures of texels, chart by
/// chart.
#pragma once

#include <vector>

#include "analysis/cracks/line_mask.h"
#include "analysis/evaluation/coherence.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

/// One kind of lines at one contrast.
struct LineFigures {
  LineKind kind = LineKind::Dark;
  double threshold = 0.0;       ///< L* by which a line differs from what surrounds it.
  std::vector<Figure> figures;  ///< As below, without the mean; `split` is the source's.
};

struct StructureFigures {
  std::vector<Figure> figures;  ///< Means over three thresholds.
  std::vector<LineFigures> lines;
  std::vector<Picture> pictures;  ///< Center lines and dead ends; none without lines.
};

/// At three thresholds, of the source laid on a plane of the same texels (nearest pixel) as `split`: line_share (of the
/// area), line_share_wanted (wanted_share(), as far as lines are found again when the charts are cut out of the
/// source; with controls on both sides), dead_ends (1/mm), closed_share (area of cells that touch no border of a
/// chart), dead_ends_crops and closed_share_crops (the same of charts cut out of the source's corners), line_length
/// (mm/mm2), line_length_q1 .. q4 (where the control is in the source's first .. fourth quarter; with controls on both
/// sides), junctions (1/mm2), median_cell (mm2), median_cell_crops. Dark lines; for bright ones, where the source has
/// them, the same as bright_*.
///
/// The source has lines of a kind if at each threshold they take up 0.3 to 25 % of it and have at most one dead end
/// every 40 px: thresholds are 7, 10 and 16 L*, or, where those see noise or nothing, multiples by a power of the root
/// of two, the nearest first. Without lines those without _crops and _q are undefined and say so.
/// @param texel_size_px  Source pixels along a texel's side. Same bits for any number of threads.
[[nodiscard]] StructureFigures measure_lines(const SynthesisSource& source, const SynthesizedMap& map,
                                             const SourceIndices& indices, double texel_size_px,
                                             const RunControl& control = {});

}  // namespace patinate::analysis
