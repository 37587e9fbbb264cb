/// \file
/// The levels of a synthesis: from the atlas's own to the coarsest.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "patinate/transfer/appearance_space.h"
#include "transfer/synthesis/levels.h"

namespace patinate::transfer {

/// @throws InvalidInput that says how many pixels there are, and how many are needed.
void check_large_enough(const History& history, const ImageU8& mask, int radius_px);

/// How many levels there are at most.
/// @param halvings  Of the history before it is laid on the atlas. @param width,height  Of the atlas.
[[nodiscard]] int usable_levels(const History& history, int halvings, int width, int height,
                                const TransferOptions& options);

/// Source that synthesis copies on level `l` of the appearance. @param first  The level that the atlas itself is
/// matched with.
[[nodiscard]] SourceLevel make_pyramid_source(const AppearanceSpace& appearance,
                                              const std::vector<ControlImage>& controls, std::size_t l,
                                              std::size_t first, const Neighborhood& neighborhood);

/// Texels that are covered on a coarse level but by no fine texel keep a control of their own: that of the finer level
/// by position. @param fill  Called for those of `part` with the fine texel.
void for_each_uncovered(const TexelMap& coarse, const TexelMap& fine, const TexelRect& part,
                        const std::function<void(int x, int y, TexelId fine)>& fill, const RunControl& control);

/// Levels of a synthesis from levels.size() on, until there is nothing to copy or to cover.
/// @param controls  Of the first of them. @param map  Of it. @param placement  As it was for level 0.
void append_levels(std::vector<SynthesisLevel>& levels, const AppearanceSpace& appearance, std::size_t first,
                   const std::vector<ControlImage>& source_controls, ControlImage controls,
                   std::shared_ptr<const TexelMap> map, SourcePlacement placement, const Neighborhood& neighborhood,
                   const RunControl& control);

/// A place on a halved level as the history's own pixel: the middle of what it covers.
[[nodiscard]] std::int32_t to_full_size(std::int32_t pixel, int coarse_width, int halvings, int full_width);
/// Keeps the fraction beside the middle, too.
[[nodiscard]] SourcePlace to_full_size(const SourcePlace& place, int coarse_width, int halvings, int full_width);
/// The place on a halved level that to_full_size() makes this place of.
[[nodiscard]] SourcePlace from_full_size(const SourcePlace& place, int coarse_width, int halvings, int full_width);

}  // namespace patinate::transfer
