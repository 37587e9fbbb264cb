/// \file
/// Whether lines hang together: dead ends, closed cells, length; what a texture loses first when it is copied in
/// pieces.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// Lines and cells of one picture, or of several charts: sums, so that charts can be added.
struct LineStructure {
  double surface_px = 0.0;                       ///< Area inside the mask.
  double line_px = 0.0;                          ///< Area of the lines.
  double length_px = 0.0;                        ///< Length of the center lines.
  double inner_length_px = 0.0;                  ///< Length of those away from every border.
  double closed_px = 0.0;                        ///< Area of cells that touch neither border nor outside.
  std::int64_t num_ends = 0;                     ///< Dead ends: ends of center lines away from every border.
  std::int64_t num_junctions = 0;                ///< Places where three or more branches meet.
  std::vector<double> cells_px = {};             ///< Areas of closed cells, at least 16 pixels each.
  std::array<double, 4> quarter_length_px = {};  ///< Length and area where the quarter is 0 .. 3.
  std::array<double, 4> quarter_surface_px = {};

  LineStructure& operator+=(const LineStructure& other);
  [[nodiscard]] double share() const { return surface_px > 0.0 ? line_px / surface_px : 0.0; }
  [[nodiscard]] double closed_share() const { return surface_px > 0.0 ? closed_px / surface_px : 0.0; }
  /// Dead ends for a pixel of length; nothing without lines away from borders.
  [[nodiscard]] std::optional<double> ends_per_px() const;
  [[nodiscard]] std::optional<double> median_cell_px() const;
};

/// Settings of measure_structure().
struct LineStructureOptions {
  double spur_px = 5.0;  ///< Branches of center lines, and lines, that are shorter are left out; >= 0.
  int border_px = 6;     ///< An end nearer than this to the picture's border or the outside is no dead end; >= 0.
};

/// A pixel wide lines without the branches that lead from a junction to an end in less than `spur_px` steps, and
/// without lines that are shorter as a whole. @param lines  As thinned() gives them.
[[nodiscard]] ImageU8 pruned(const ImageU8& lines, double spur_px);

/// Pixels of `lines` at which a center line ends, border_px or more (along both axes) away from the border and the
/// outside. 0 / 255.
[[nodiscard]] ImageU8 dead_ends(const ImageU8& lines, const ImageU8& mask, int border_px);

/// @param lines    H x W, not 0 = line, of any width. @param mask  H x W, 0 = outside; may be empty.
/// @param quarter  H x W, 0 .. 3: of a control's values, the class that length is told for; other values: none. May be
/// empty.
/// @throws InvalidInput if sizes differ or an option is out of range.
[[nodiscard]] LineStructure measure_structure(const ImageU8& lines, const ImageU8& mask, const ImageU8& quarter,
                                              const LineStructureOptions& options = {}, const RunControl& control = {});

}  // namespace patinate::analysis
