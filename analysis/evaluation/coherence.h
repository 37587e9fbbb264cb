/// \file
/// How a coordinate map hangs together: copied pieces, repetition, what happens at seams, and whether the source keeps
/// its scale.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis/evaluation/synthesized_map.h"

namespace patinate::analysis {

/// Neighbors that are neighbors in the source too.
struct CoherenceFigures {
  double coherent_share = 0.0;    ///< Pairs of texels right of and below each other in a chart whose step in the source
                                  ///< is that on the surface, to less than a pixel.
  double texels_per_piece = 0.0;  ///< Covered texels by the pieces that such pairs connect.
  std::vector<std::int32_t> piece;  ///< Of every texel, numbered by their first one; -1 outside.
};
/// How steps on the surface are compared with steps in the source.
struct SourceScale {
  const FlowFrames& frames;  ///< Which way the source lies.
  double pixel_mm = 1.0;     ///< Surface length of a source pixel.
  double unit_px = 1.0;  ///< What a place in the source is known to: 2^k pixels where the source was halved k times, or
                         ///< a texel where that is more.
};
/// Whether the step in the source is that on the surface, to less than a unit.
[[nodiscard]] bool follows_surface(const SourceIndices& source, const TexelPair& pair, const SourceScale& scale);

[[nodiscard]] CoherenceFigures measure_coherence(const TexelMap& surface, const SourceIndices& source,
                                                 const SourceScale& scale);

/// A source pixel that is seen again nearby is a motif that repeats.
struct ReuseFigures {
  double rep64 = 0.0;                     ///< Texels whose source pixel shows again 4 to 64 texels away.
  double used_share = 0.0;                ///< Source pixels inside the mask that show anywhere.
  std::vector<std::uint8_t> is_repeated;  ///< Of every texel.
};
/// @param num_usable  Pixels of the source that could be used.
[[nodiscard]] ReuseFigures measure_reuse(const TexelMap& surface, const SourceIndices& source, std::int64_t num_usable);

/// Across seams against pairs inside charts that are as far apart (to half a texel; pairs over 6 texels apart are left
/// out): 1 = a seam cannot be told from any other place.
struct SeamFigures {
  std::int64_t num_pairs = 0;
  std::optional<double> gradient_ratio;   ///< Color difference, mean over all frames.
  std::optional<double> coherence_ratio;  ///< Share of pairs whose step in the source is that on the surface.
};
/// @param frames  Of the source, as in SynthesisSource. Both ratios are undefined without seams.
[[nodiscard]] SeamFigures measure_seams(const TexelMap& surface, const SourceIndices& source,
                                        std::span<const TexelPair> seams, const SynthesisSource& frames,
                                        const SourceScale& scale, const RunControl& control = {});

/// Whether copied pieces have the source's size on the surface, whatever the UVs do.
struct ForeshorteningFigures {
  std::int64_t num_spans = 0;
  std::optional<double> median;  ///< Of 2^|log2(source length / surface length)| - 1.
  std::optional<double> p99;
};
/// Over spans of 8 to 32 texels along rows and columns inside one copied piece: steps of at most 5 source pixels that
/// go the way the surface goes. Undefined where there are none.
[[nodiscard]] ForeshorteningFigures measure_foreshortening(const TexelMap& surface, const SourceIndices& source,
                                                           const SourceScale& scale, const RunControl& control = {});

}  // namespace patinate::analysis
