/// \file
/// What texture synthesis is given, at one level of the pyramid: pixels that can be copied, and texels that are to be
/// covered.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "libcommon/atlas/texel_neighborhood.h"
#include "libcommon/atlas/texel_set.h"
#include "patinate/atlas/texel_map.h"
#include "patinate/core/run_control.h"
#include "patinate/transfer/appearance_space.h"
#include "patinate/transfer/transfer.h"

namespace patinate::transfer {

class FrameTurns;

struct Offset {
  int x = 0, y = 0;
};

/// Neighbors that are compared: a square around the texel (without it), with weights that fall outward; those of most
/// weight first.
struct Neighborhood {
  std::vector<Offset> offsets;
  std::vector<std::int16_t> weights;  ///< > 0; at most 16 each, kLargestSum in all.
  /// Bound of a neighborhood's weights: sums of differences then fit into 32 bits.
  static constexpr int kLargestSum = 1024;
  int radius_px = 0;

  /// @param radius_px  [1, 5]
  [[nodiscard]] static Neighborhood square(int radius_px);
};

/// The history at one level: what can be copied.
struct SourceLevel {
  AppearanceImage appearance;
  ControlImage controls;
  int margin_px = 0;                    ///< On every side, added for comparisons: nothing there is usable.
  std::vector<std::uint8_t> is_usable;  ///< Per pixel: it can be copied, and its whole neighborhood can be compared.
  std::vector<std::int32_t> usable;     ///< The usable pixels, ascending by first control, then by index.
  double appearance_variance = 1.0;
  std::vector<double> control_variances;

  [[nodiscard]] int width() const { return appearance.width(); }
  [[nodiscard]] int height() const { return appearance.height(); }
  /// Usable pixels of similar control values, never empty. One control: those within `tolerance` of the target, or the
  /// nearest. Several: those of the target's cell in a grid over the first two, or of the nearest cell that holds any.
  [[nodiscard]] std::span<const std::int32_t> similar(std::span<const std::uint16_t> target, int tolerance) const;
  std::vector<std::int32_t>
      first_with;  ///< Per value v in [0, kControlSteps + 1] of the first control: how many of `usable` lie below v.
  /// Grid over the first two controls: `grid_pixels[grid_begin[c] .. grid_begin[c + 1])` of the cell that `grid_cell`
  /// leads to.
  static constexpr int kGridSide = 64;
  std::vector<std::int32_t> grid_cell, grid_begin, grid_pixels;
};

/// The finest level: usable are the pixels whose whole neighborhood lies in the mask. `usable` is empty where there is
/// none: such a level cannot be copied from.
[[nodiscard]] SourceLevel make_source_level(AppearanceImage appearance, ControlImage controls, const ImageU8& mask,
                                            double appearance_variance, const Neighborhood& neighborhood);
/// A coarser level: all pixels in the mask are usable, and see the history mirrored at its border. There a neighborhood
/// covers a large part of the history; were its middle alone usable, results would hardly ever be taken from elsewhere.
[[nodiscard]] SourceLevel make_coarse_source_level(const AppearanceImage& appearance, const ControlImage& controls,
                                                   const ImageU8& mask, double appearance_variance,
                                                   const Neighborhood& neighborhood);

/// How a source lies on the surface.
struct SourcePlacement {
  std::shared_ptr<const FlowFrames> frames;           ///< Directions of its rows and columns.
  double pixel_mm = 1.0;                              ///< Surface length of a source pixel of this level.
  double step_mm = 1.0;                               ///< Step of an offset of 1: about a pixel, and about a texel.
  std::shared_ptr<const FrameTurns> turns = nullptr;  ///< Pieces may turn against the frames; null: they follow them.
};

/// The surface at one level: what is to be covered.
struct DestinationLevel {
  std::shared_ptr<const TexelMap> map;
  ControlImage controls;  ///< Mapped into the source's values.
  SourcePlacement placement;
  TexelSet texels;  ///< The covered ones.
  std::shared_ptr<const TexelNeighborhood> neighbors =
      nullptr;  ///< None until find_neighbors(): they take the most memory by far on coarse levels.

  [[nodiscard]] int num_controls() const { return controls.channels(); }
  /// num_controls() a texel.
  [[nodiscard]] const std::uint16_t* targets() const { return controls.data(); }
  [[nodiscard]] std::span<const std::uint16_t> target(TexelId t) const {
    return {targets() + t * num_controls(), static_cast<std::size_t>(num_controls())};
  }
};

/// Without neighbors.
[[nodiscard]] DestinationLevel cover_level(std::shared_ptr<const TexelMap> map, ControlImage controls,
                                           SourcePlacement placement, const RunControl& control = {});
/// Those that are compared.
void find_neighbors(DestinationLevel& level, const Neighborhood& neighborhood, const RunControl& control = {});
/// Both.
[[nodiscard]] DestinationLevel make_destination_level(std::shared_ptr<const TexelMap> map, ControlImage controls,
                                                      const Neighborhood& neighborhood,
                                                      const SourcePlacement& placement, const RunControl& control = {});

/// One level of the pyramid.
struct SynthesisLevel {
  SourceLevel source;
  DestinationLevel destination;
};

}  // namespace patinate::transfer
