#include "transfer/synthesis/audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/window_search.h"

namespace patinate::transfer {

namespace {

constexpr std::int64_t kAuditChunk = 4;  // Texels: some ms each in a large source.
constexpr std::uint32_t kPurpose = 500;  // Purpose of RandomStream.

/// The texel's own pixel and those to which its neighbors lead: they bound the search.
std::vector<std::int32_t> likely_pixels(const SourceLevel& source, const TexelCost& cost,
                                        const CoordinateMap& coordinates, std::int32_t own) {
  const search_kernel::SourceTables tables = source_tables(source);
  std::vector<std::int32_t> likely{own};
  for (const PixelNeighbor& n : cost.adjacent()) {
    const std::int32_t s = n.texel < 0 ? -1 : coordinates[n.texel];
    if (s >= 0) likely.push_back(window_kernel::led_pixel(&tables, s, n));  // -1 is skipped.
  }
  return likely;
}

double ratio_of(double cost, double least) {
  if (least > 0.0) return cost / least;
  return cost > 0.0 ? std::numeric_limits<double>::infinity() : 1.0;
}

std::optional<double> finite(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

}  // namespace

std::vector<TexelId> drawn_texels(const TexelSet& texels, std::int64_t before, std::int64_t all, std::int64_t count,
                                  std::uint64_t seed) {
  const auto size = static_cast<std::int64_t>(texels.size());
  if (all <= count) return {texels.begin(), texels.end()};
  std::vector<TexelId> drawn;
  for (std::int64_t i = 0; i < count; ++i) {  // One of each of `count` equal parts.
    const std::int64_t begin = i * all / count, end = (i + 1) * all / count;
    const std::uint32_t chosen =
        RandomStream(seed, static_cast<std::uint64_t>(i), kPurpose).below(static_cast<std::uint32_t>(end - begin));
    const std::int64_t here = begin + chosen - before;
    if (here >= 0 && here < size) drawn.push_back(texels[here]);
  }
  return drawn;
}

OptimumAudit summary_of(std::span<const AuditedTexel> all) {
  OptimumAudit audit;
  std::int64_t optimal = 0;
  std::vector<double> ratios;
  for (const AuditedTexel& c : all) {
    if (c.own < 0) {
      ++audit.num_excluded;
      continue;
    }
    audit.energy += static_cast<double>(c.own);
    audit.optimum += static_cast<double>(c.least);
    optimal += c.own == c.least ? 1 : 0;
    ratios.push_back(ratio_of(static_cast<double>(c.own), static_cast<double>(c.least)));
  }
  audit.num_audited = static_cast<std::int64_t>(ratios.size());
  if (ratios.empty()) return audit;
  const auto n = static_cast<double>(ratios.size());
  audit.ratio = finite(ratio_of(audit.energy, audit.optimum));
  audit.energy /= n * EnergyScale::kOne;
  audit.optimum /= n * EnergyScale::kOne;
  audit.optimal_share = static_cast<double>(optimal) / n;
  audit.median_ratio = finite(median(std::move(ratios)));
  return audit;
}

std::vector<AuditedTexel> audit_texels(const SynthesisLevel& level, const Neighborhood& neighborhood,
                                       const CoordinateMap& coordinates, std::span<const TexelId> texels,
                                       double coherence_share, std::span<const double> control_weights,
                                       const RunControl& control, std::span<const Turn> turns) {
  const SourceLevel& source = level.source;
  const EnergyScale scale = EnergyScale::make(source, coherence_share, control_weights);
  std::vector<AuditedTexel> costs(texels.size());
  std::vector<std::size_t> audited;
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const std::int32_t own = coordinates[texels[i]];
    if (own >= 0 && source.is_usable[own] != 0) audited.push_back(i);
  }
  if (audited.empty()) return costs;
  RunControl silent = control;
  silent.on_progress = nullptr;
  const WindowSearch search(source, neighborhood, std::max(source.width(), source.height()), silent);
  const SearchWindow whole{.x0 = 0, .y0 = 0, .x1 = source.width(), .y1 = source.height()};
  parallel_for(static_cast<std::int64_t>(audited.size()), kAuditChunk, control,
               [&](std::int64_t begin, std::int64_t end) {
                 TexelCost cost(source, level.destination, neighborhood);
                 for (std::int64_t k = begin; k < end; ++k) {
                   const std::size_t i = audited[k];
                   const std::int32_t own = coordinates[texels[i]];
                   cost.prepare(texels[i], coordinates, scale, turns.empty() ? Turn{0} : turns[texels[i]]);
                   costs[i] = {.own = cost.total(own, std::numeric_limits<std::int64_t>::max()),
                               .least = search.find(cost, whole, likely_pixels(source, cost, coordinates, own)).cost};
                 }
               });
  return costs;
}

OptimumAudit audit_optimum(const SynthesisLevel& level, const Neighborhood& neighborhood,
                           const CoordinateMap& coordinates, double coherence_share,
                           std::span<const double> control_weights, std::int64_t num_audits, std::uint64_t seed,
                           const RunControl& control) {
  if (!(num_audits > 0)) throw InvalidInput("audits: " + std::to_string(num_audits) + " is out of range; use > 0");
  const TexelSet& texels = level.destination.texels;
  const std::vector<TexelId> drawn =
      drawn_texels(texels, 0, static_cast<std::int64_t>(texels.size()), num_audits, seed);
  return summary_of(audit_texels(level, neighborhood, coordinates, drawn, coherence_share, control_weights, control));
}

}  // namespace patinate::transfer
