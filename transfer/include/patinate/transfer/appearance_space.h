/// \file
/// Appearance space: what a pixel looks like over its whole history, as eight small integers, so that two pixels are
/// compared at all times at once [Lefebvre and Hoppe 2006, "Appearance-space texture synthesis", sec. 3].
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/options.h"
#include "patinate/core/run_control.h"
#include "patinate/history/history_value.h"
#include "patinate/image/image.h"

namespace patinate::transfer {

/// Structure that copied pieces must not cut: lines, or the borders of regions of two materials.
enum class StructureKind { DarkLines, BrightLines, Regions };
inline constexpr std::array<std::string_view, 3> kStructureKindNames{"dark_lines", "bright_lines", "regions"};

/// Structure that was found in the source (structure.h).
struct StructureFacts {
  StructureKind kind = StructureKind::DarkLines;
  double share = 0.0;         ///< Of the source's pixels: on lines, or of the rarer material.
  double scale_px = 0.0;      ///< About half of the largest cell between lines, or of the largest region; pixels of the
                              ///< history.
  double contrast_lab = 0.0;  ///< Of the faintest lines, or between the two materials, L*.
};

inline constexpr int kAppearanceVersion =
    3;  ///< Raised when the same history gives other integers: kept ones are then regenerated.
inline constexpr int kAppearanceSize = 8;     ///< Components per pixel: eight int16, one SSE register.
inline constexpr int kAppearanceLimit = 511;  ///< Components lie in [-511, 511]: differences squared fit our sums.

using AppearanceImage = Image<std::int16_t>;  ///< H x W x 8.

struct AppearanceOptions {
  int spatial_radius_px = 1;   ///< [0, 3]. Neighbors that count into a pixel's appearance; 0 = itself only.
  int max_frames = 96;         ///< [2, 128]. Longer histories are compared at this many evenly spaced frames.
  int num_samples = 8192;      ///< [64, 65536]. Pixels from which the components are found.
  double material_maps = 0.5;  ///< [0, 10]. Variance of gloss, metalness and relief together, beside that of colors.
  double structure = 1.0;      ///< [0, 10]. Variance of structure, if the source has any, beside that of colors.
  std::string structure_map = {};  ///< Control of the history that says where structure is; "": it is looked for.
};
void describe(OptionVisitor& v, AppearanceOptions& o);

/// Indices of the frames that are compared: all, or `max_frames` evenly spaced ones with both ends.
[[nodiscard]] std::vector<int> compared_frames(int num_frames, int max_frames);

/// Appearance at every level of a pyramid, finest first, and how much of the history it holds.
struct AppearanceSpace {
  std::vector<AppearanceImage>
      levels;                       ///< levels[l] is about (W >> l) x (H >> l). Does not depend on how many there are.
  std::vector<ImageU8> masks;       ///< 0 / 255 of each level; a coarse pixel is inside when all it covers is.
  std::vector<double> variances;    ///< Per level: total variance of the appearance inside the mask, squared units.
  double explained_variance = 0.0;  ///< Share of the temporal variance that the components keep, in [0, 1].
};

/// Projects every pixel's colors over time (square-root encoded, so that dark differences count as the eye sees them),
/// with its `specular`, `metalness` and `height`, of every frame or constant, on their leading components, then each
/// pixel's neighborhood of components on the leading spatial ones.
///
/// Streams over the frames twice; memory is O(W H 8), whatever the number of frames. Uses + - * / and sqrt only, in a
/// fixed order: same bits for any number of threads.
/// @param num_levels  >= 1; fewer come where nothing is inside a coarser level. @param given_mask  Taken instead of the
/// history's own; of its size. Empty: its own.
/// @throws InvalidInput if the mask is empty everywhere.
[[nodiscard]] AppearanceSpace build_appearance_space(const History& history, int num_levels,
                                                     const AppearanceOptions& options = {},
                                                     const RunControl& control = {}, const ImageU8& given_mask = {});

/// A function that provides the history's appearance instead of building it; its result must be equal
/// (appearance_cache.h).
using AppearanceSource = std::function<AppearanceSpace(int num_levels, const AppearanceOptions& options,
                                                       const RunControl& control, const ImageU8& given_mask)>;
/// From `source`; where that is empty, built.
[[nodiscard]] AppearanceSpace appearance_of(const History& history, const AppearanceSource& source, int num_levels,
                                            const AppearanceOptions& options, const RunControl& control,
                                            const ImageU8& given_mask);

}  // namespace patinate::transfer
