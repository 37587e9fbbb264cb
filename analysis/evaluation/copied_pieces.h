/// \file
/// Copied pieces: whether features go on over their borders, and whether some places of the source are used more than
/// others.
#pragma once

#include <cstdint>
#include <optional>

#include "analysis/evaluation/coherence.h"

namespace patinate::analysis {

/// Pairs of texels right of and below each other in a chart whose step in the source is not that on the surface.
struct BorderSums {
  std::int64_t count = 0;
  double shown = 0.0, own = 0.0;

  void add(const BorderSums& other);
  /// 1 = features go on as in the source; 1 without borders; nothing where the source is flat wherever pieces meet.
  [[nodiscard]] std::optional<double> contrast() const;
};
/// Sum over such pairs (t, n), and over all frames, of |A(s(t)) - A(s(n))|, A = (R, G, B, and the luma's two central
/// differences) in codes, against what the source itself has there at the same step d: the mean of
/// |A(s(t)) - A(s(t) + d)| and |A(s(n) - d) - A(s(n))|. Same bits for any number of threads.
/// @param frames  With their mask: steps that leave it are left out.
[[nodiscard]] BorderSums measure_borders(const MapPart& part, const SynthesisSource& frames, const SourceScale& scale,
                                         const RunControl& control = {});

/// Share of texels whose source is used more often than if all of it were used evenly, wherever that is: 0 where a
/// source is used once, or where each pixel is used as often as every other; 8/9 where a ninth of it is used for all.
/// @param width  Of the source. @param num_usable  Pixels of it that could be used. @param pixels_per_texel  Along a
/// side: pixels that one texel covers are one place; texels that one pixel covers do not repeat it.
[[nodiscard]] double overuse_of(const ReuseSums& reuse, int width, std::int64_t num_usable, double pixels_per_texel);

}  // namespace patinate::analysis
