/// \file
/// Structure of a source: what a texture is made of and a copy must not break. Lines, such as cracks, veins and rims;
/// or the borders of regions, such as rust on paint.
#pragma once

#include <optional>

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"
#include "patinate/transfer/appearance_space.h"

namespace patinate::transfer {

inline constexpr int kStructureSize = 5;  ///< Channels.

/// Lines of a history's last frame, dark or bright, at two thresholds: all, and those that contrast most; where there
/// are none, its regions.
struct SourceStructure {
  /// H x W x kStructureSize; empty where there are no lines. For both thresholds 2 (1 - exp(-D / scale_px)), with D the
  /// distance to the nearest line: it does not saturate inside a cell, so that erasing a line costs something wherever
  /// its cells are looked at; 1 - exp(-6 D / scale_px) for all lines, which tells where they run; and for both how
  /// surely a pixel is on one. [0, 2], and [0, 1] for the last three.
  /// For regions: 1 -+ (1 - exp(-D / scale_px)) with D the distance to the border, below 1 in the darker and above in
  /// the brighter material; the same for 6 D; and how surely a pixel is of the brighter; [0, 2] and [0, 1].
  ImageF channels;
  StructureKind kind = StructureKind::DarkLines;
  double share = 0.0;     ///< Share of the pixels inside the mask that are on a line, or of the rarer material.
  double scale_px = 0.0;  ///< About half of the largest cell, or of the largest region.
  double weight = 1.0;    ///< Weight of structure against tone, (0, 1]: lines that are rare say little about the rest.
  double refused_line_share =
      0.0;                ///< Share of pixels that look like lines but are too many; 0 where lines were found.
  double contrast = 0.0;  ///< Lightness by which lines differ from what surrounds them, at the lower threshold; between
                          ///< the means of regions; L*.

  [[nodiscard]] bool empty() const { return channels.empty(); }
};
/// Facts for transfer.json; none of an empty one.
[[nodiscard]] std::optional<StructureFacts> facts_of(const SourceStructure& structure);

/// Structure of a history's last frame: find_lines(), else find_regions(), or what `options.structure_map` says: a
/// control of the history that is high on lines, or on one of two materials where that is more than a quarter. None
/// with `options.structure` 0. Same bits for any number of threads.
/// @param mask  H x W, 0 = outside. @throws InvalidInput if there is no such control.
[[nodiscard]] SourceStructure find_structure(const History& history, const ImageU8& mask,
                                             const AppearanceOptions& options = {}, const RunControl& control = {});
/// H x W, L* of a frame's luminance [CIE 15]. The same bits everywhere.
[[nodiscard]] ImageF lightness_of(const ImageF& frame);
/// Lines of one picture. @param lightness  H x W, L*.
[[nodiscard]] SourceStructure line_structure(const ImageF& lightness, const ImageU8& mask,
                                             const RunControl& control = {});

}  // namespace patinate::transfer
