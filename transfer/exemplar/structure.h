/// \file
/// Structure of a source: lines that a texture is made of, such as cracks, veins and rims, which a copy must not break.
#pragma once

#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

inline constexpr int kStructureSize = 5;  ///< Channels.

/// Lines of a history's last frame, dark or bright, at two thresholds: all, and those that contrast most.
struct SourceStructure {
  /// H x W x kStructureSize; empty where there are no lines. For both thresholds 2 (1 - exp(-D / scale_px)), with D the
  /// distance to the nearest line: it does not saturate inside a cell, so that erasing a line costs something wherever
  /// its cells are looked at; 1 - exp(-6 D / scale_px) for all lines, which tells where they run; and for both how
  /// surely a pixel is on one. [0, 2], and [0, 1] for the last three.
  ImageF channels;
  double share = 0.0;     ///< Of the pixels inside the mask that are on a line.
  double scale_px = 0.0;  ///< About half of the largest cell.
  bool is_dark = true;
  double contrast = 0.0;  ///< Lightness by which lines differ from what surrounds them, at the lower threshold, L*.

  [[nodiscard]] bool empty() const { return channels.empty(); }
};

/// Lines are what a closing (dark) or an opening (bright) of the lightness by a square fills, at the smallest of four
/// sizes that finds most of them: above Otsu's threshold [Otsu 1979], and above 0.4 of it or the noise where connected
/// with that. There is structure where most of what is found is much longer than wide. Same bits for any number of
/// threads.
/// @param mask  H x W, 0 = outside.
[[nodiscard]] SourceStructure find_structure(const History& history, const ImageU8& mask,
                                             const RunControl& control = {});
/// Of one picture. @param lightness  H x W, L*.
[[nodiscard]] SourceStructure find_structure(const ImageF& lightness, const ImageU8& mask,
                                             const RunControl& control = {});

}  // namespace patinate::transfer
