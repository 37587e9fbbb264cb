/// \file
/// How a coordinate map hangs together: copied pieces, repetition, what happens at seams, and whether the source keeps
/// its scale.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis/evaluation/synthesized_map.h"
#include "analysis/evaluation/value_counts.h"

namespace patinate::analysis {

/// How steps on the surface are compared with steps in the source.
struct SourceScale {
  SourceAxes axes;
  double pixel_mm = 1.0;  ///< Surface length of a source pixel.
  double unit_px = 1.0;   ///< Precision of a place in the source: 2^k pixels where the source was halved k times, or
                          ///< a texel where that is more.
};
/// Whether the step in the source is that on the surface, to less than a unit.
[[nodiscard]] bool follows_surface(const SourceIndices& source, const TexelPair& pair, const SourceScale& scale);

/// Neighbors that are neighbors in the source too. Sums of parts, here and below, add up to those of the whole: no
/// chart leaves its part, and no sum reaches from chart to chart except over seams.
struct CoherenceSums {
  std::int64_t pairs = 0, coherent = 0;  ///< Texels right of and below each other in a chart; those whose step in the
                                         ///< source is that on the surface, to less than a pixel.
  std::int64_t texels = 0, pieces = 0;   ///< Covered texels; what such pairs connect.

  void add(const CoherenceSums& other);
  [[nodiscard]] double coherent_share() const;
  [[nodiscard]] double texels_per_piece() const;
};
[[nodiscard]] CoherenceSums measure_coherence(const MapPart& part, const SourceScale& scale);

/// A source pixel that is seen again nearby is a motif that repeats.
struct ReuseSums {
  std::int64_t texels = 0, repeated = 0;  ///< Those whose source pixel shows again in the part 4 to 64 texels away.
  std::vector<std::int64_t> uses;         ///< By pixel of the source: texels that show it.

  void add(const ReuseSums& other);
  [[nodiscard]] double rep64() const;
  /// @param num_usable  Pixels of the source that could be used.
  [[nodiscard]] double used_share(std::int64_t num_usable) const;
};
/// @param num_pixels  Of the source. @param is_repeated  1 where counted, of the rectangle.
[[nodiscard]] ReuseSums measure_reuse(const MapPart& part, std::int64_t num_pixels, ImageF& is_repeated);

/// Pairs of texels that are about as far apart.
struct PairSums {
  std::int64_t count = 0, following = 0;
  double difference = 0.0, distance = 0.0;

  void add(const TexelPair& pair, const SourceIndices& source, const SynthesisSource& frames, const SourceScale& scale);
  void add(const PairSums& other);
  [[nodiscard]] double gradient() const { return distance > 0.0 ? difference / distance : 0.0; }
  [[nodiscard]] double following_share() const { return static_cast<double>(following) / static_cast<double>(count); }
};
/// Around multiples of half a texel: a texture's differences do not grow with the distance, so that only pairs of equal
/// distance can be compared.
using PairsByDistance = std::array<PairSums, 12>;

/// Across seams against pairs inside charts that are as far apart (to half a texel; pairs over 6 texels apart are left
/// out): 1 = a seam cannot be told from any other place.
struct SeamFigures {
  std::int64_t num_pairs = 0;
  std::optional<double> gradient_ratio;   ///< Color difference, mean over all frames.
  std::optional<double> coherence_ratio;  ///< Share of pairs whose step in the source is that on the surface.
};
struct SeamSums {
  PairsByDistance over = {}, inside = {};

  void add(const SeamSums& other);
  /// Against pairs of the same distance, or where there are few of those, of the nearest distance that has more. Both
  /// ratios are undefined without seams.
  [[nodiscard]] SeamFigures figures() const;
};
/// @param frames  Of the source, as in SynthesisSource.
[[nodiscard]] SeamSums measure_seams(const MapPart& part, std::span<const TexelPair> seams,
                                     const SynthesisSource& frames, const SourceScale& scale,
                                     const RunControl& control = {});

/// Whether copied pieces have the source's size on the surface, whatever the UVs do: |log2(source length / surface
/// length)| over spans of 8 to 32 texels along rows and columns inside one copied piece: steps of at most 5 source
/// pixels that go the way the surface goes. In bins of 2^-16.
[[nodiscard]] ValueCounts measure_foreshortening(const MapPart& part, const SourceScale& scale,
                                                 const RunControl& control = {});
/// 2^value - 1 of the middle one and of the 99th percentile; nothing where there are none.
struct ForeshorteningFigures {
  std::optional<double> median, p99;
};
[[nodiscard]] ForeshorteningFigures foreshortening_of(const ValueCounts& logarithms);

}  // namespace patinate::analysis
