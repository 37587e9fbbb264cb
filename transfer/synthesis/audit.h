/// \file
/// How near a coordinate map is to the least energy that each single texel could reach: the search is judged, whichever
/// tool made the map.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "patinate/core/run_control.h"
#include "transfer/synthesis/energy.h"
#include "transfer/synthesis/levels.h"

namespace patinate::transfer {

/// Costs of the map's own pixels, and those of the best pixels there are while the neighbors stay as they are.
struct OptimumAudit {
  std::int64_t num_audited = 0;
  std::int64_t num_excluded =
      0;  ///< Drawn as well, but their pixel has not its whole neighborhood in the mask: it has no cost.
  double energy =
      0.0;  ///< Mean cost of the map's own pixels: the map's energy, of the audited texels. 1 for random texels.
  double optimum = 0.0;                ///< Mean least cost.
  double optimal_share = 0.0;          ///< Texels for which no pixel costs less than theirs.
  std::optional<double> ratio;         ///< energy / optimum; 1 when both are 0, nothing when only the optimum is.
  std::optional<double> median_ratio;  ///< Median ratio texel by texel; nothing when that is infinite.
};

/// The cost of a texel's own pixel, -1 where it has none, and the least that there is.
struct AuditedTexel {
  std::int64_t own = -1;
  std::int64_t least = 0;
  friend bool operator==(const AuditedTexel&, const AuditedTexel&) = default;
};

/// Those drawn by `seed` from a part of an atlas: `count` in the whole atlas, spread evenly, or all where there are not
/// more. @param texels  The part's covered ones. @param before  In earlier parts. @param all  In all parts.
[[nodiscard]] std::vector<TexelId> drawn_texels(const TexelSet& texels, std::int64_t before, std::int64_t all,
                                                std::int64_t count, std::uint64_t seed);
/// The least cost is that over all usable pixels of the source; WindowSearch finds it without looking at every one.
/// @param coordinates  Pixels of level.source for those texels and what they look at; -1 = none, as outside.
/// @param turns  Of the texels' pieces: a texel is compared as its own is turned. Empty: all 0.
[[nodiscard]] std::vector<AuditedTexel> audit_texels(const SynthesisLevel& level, const Neighborhood& neighborhood,
                                                     const CoordinateMap& coordinates, std::span<const TexelId> texels,
                                                     double coherence_share, std::span<const double> control_weights,
                                                     const RunControl& control = {}, std::span<const Turn> turns = {});
/// Audit of the texels of all parts, in their order. All ratios are at least 1.
[[nodiscard]] OptimumAudit summary_of(std::span<const AuditedTexel> texels);

/// All three for a whole atlas.
/// @throws InvalidInput unless num_audits > 0. Same figures for any number of threads.
[[nodiscard]] OptimumAudit audit_optimum(const SynthesisLevel& level, const Neighborhood& neighborhood,
                                         const CoordinateMap& coordinates, double coherence_share,
                                         std::span<const double> control_weights, std::int64_t num_audits,
                                         std::uint64_t seed, const RunControl& control = {});

}  // namespace patinate::transfer
