/// \file
/// Whether a texture keeps the lines of its source: cracks, veins, rims. Measured in pictures of texels, chart by
/// chart.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "analysis/evaluation/source_lines.h"
#include "analysis/evaluation/surface_windows.h"
#include "analysis/evaluation/synthesized_map.h"
#include "patinate/analysis/report_parts.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// Texels by the value of a control that they want. @param part  With a control.
[[nodiscard]] ControlCounts count_wanted(const MapPart& part);

/// The share of `feature` among the source's pixels of a control, in those bins, weighted by how often the surface
/// wants it; of values that the source has nowhere, the nearest bin that it has.
/// @param feature,control,mask  Of the source, equal in size; `feature` and `mask` 0 = no, `mask` may be empty,
/// `control` in [0, 1]. @returns nothing if no pixel or no texel counts.
[[nodiscard]] std::optional<double> wanted_share(const ImageU8& feature, const ImageF& control, const ImageU8& mask,
                                                 const ControlCounts& wanted);

/// One kind of lines at one contrast.
struct LineFigures {
  LineKind kind = LineKind::Dark;
  double threshold = 0.0;       ///< L* by which a line differs from what surrounds it.
  std::vector<Figure> figures;  ///< Figures as below, without the mean; `split` is the source's.
};

struct StructureFigures {
  std::vector<Figure> figures;  ///< Means over three thresholds.
  std::vector<LineFigures> lines;
};

/// Sums of one kind of lines in a part.
struct LineSums {
  LineStructures made, crops;  ///< By threshold; of charts cut out of the source's corners.
  LineStructures windows,
      source_windows;  ///< Lines of windows on the surface, and of the source's (surface_windows.h).
  std::array<std::int64_t, kNumLineThresholds> lines_there = {}, lines_found = {};  ///< CutSource of these charts.

  void add(const LineSums& other);
};
/// Sums of all kinds that the source has.
struct StructureSums {
  std::vector<LineSums> kinds;
  ControlCounts wanted = {};                                        ///< 0 without controls on both sides.
  ControlCounts windows_control = {}, source_windows_control = {};  ///< Of SurfaceWindows.

  void add(const StructureSums& other);
};

/// The lines of a source, and how they are measured in maps of it.
///
/// At three thresholds, of the source laid on a plane of the same texels (nearest pixel) as `split`: line_share (of the
/// area), line_share_wanted (wanted_share(), as far as lines are found again when the charts are cut out of the
/// source; with controls on both sides), dead_ends (1/mm), closed_share (area of cells that touch no border of a
/// chart), dead_ends_crops and closed_share_crops (the same of charts cut out of the source's corners), line_length
/// (mm/mm2), line_length_q1 .. q4 (where the control is in the source's first .. fourth quarter; with controls on both
/// sides), junctions (1/mm2), median_cell (mm2), median_cell_crops; line_share_surface, dead_ends_surface (1/mm) and
/// closed_share_surface of windows that lie across seams, with windows of the source as `split`: turned alike, of the
/// same shape, where the control is the same on average; the share's is corrected for the difference of their controls.
/// Dark lines; for bright ones, where the source has them, the same as
/// bright_*.
///
/// The source has lines of a kind if at each threshold they take up 0.3 to 25 % of it and have at most one dead end
/// every 40 px: thresholds are 7, 10 and 16 L*, or, where those see noise or nothing, multiples by a power of the root
/// of two, the nearest first. Without lines those without _crops and _q are undefined and say so.
/// Same bits for any number of threads.
class SourceStructure {
 public:
  /// @param source  Must outlive this. @param texel_size_px  Pixels along a texel's side. @param has_wanted  Maps have
  /// controls.
  SourceStructure(const SynthesisSource& source, double texel_size_px, bool has_wanted, const RunControl& control = {});
  ~SourceStructure();
  SourceStructure(const SourceStructure&) = delete;
  SourceStructure& operator=(const SourceStructure&) = delete;

  /// @param before,all  In earlier parts, and in all. @param pictures  A picture of center lines and dead ends is added
  /// for each kind, of the part's rectangle.
  [[nodiscard]] StructureSums measure(const MapPart& part, const PartCounts& before, const PartCounts& all,
                                      std::vector<Picture>& pictures, const RunControl& control = {}) const;
  /// @param sums  Of all parts.
  [[nodiscard]] StructureFigures figures(const StructureSums& sums, double texel_mm) const;

 private:
  struct Found;
  std::unique_ptr<const Found> found_;
};

}  // namespace patinate::analysis
