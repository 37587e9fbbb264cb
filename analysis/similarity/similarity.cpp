#include "analysis/similarity/similarity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "analysis/figures/aging.h"
#include "analysis/figures/spatial.h"
#include "libcommon/core/parallel.h"
#include "patinate/analysis/compare_options.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxColors = 4096;  ///< Most colors of a moment.
constexpr int kMinRings = 4;              ///< Two octaves that both spectra have.
constexpr int kFarthestSlide = 4;         ///< Half-octaves.
constexpr std::array<int, 1> kOnce{1};    ///< Everything is one block, which counts once.

std::vector<double> moments_of(const HistoryFacts& facts) {
  if (facts.frames.size() == 1) return {facts.frames.front().time};
  const double first = facts.frames.front().time, last = facts.frames.back().time;
  std::vector<double> times;
  for (std::size_t i = 0; i < kDescribedTimes; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(kDescribedTimes - 1);
    times.push_back(i + 1 == kDescribedTimes ? last : first + share * (last - first));
  }
  return times;
}

std::vector<BlockValue> sorted_shares(const std::vector<float>& times, const std::vector<std::uint8_t>& ages,
                                      double first, double last) {
  std::vector<BlockValue> shares;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (ages[i] != 0)
      shares.push_back({static_cast<float>((static_cast<double>(times[i]) - first) / (last - first)), 0});
  }
  sort_values(shares);
  return shares;
}

/// Spectra of two surfaces at pairs of moments, mean; nothing where a pair has none.
std::optional<double> structure_between(const SurfaceDescriptor& a, const SurfaceDescriptor& b,
                                        const std::vector<std::array<std::size_t, 2>>& pairs) {
  const auto mean_at = [&](double pixel_a, double pixel_b) -> std::optional<double> {
    double sum = 0.0;
    for (const auto& [i, j] : pairs) {
      const std::optional<double> d = octaves_between(a.spectra[i], pixel_a, b.spectra[j], pixel_b, kMinRings);
      if (!d) return std::nullopt;
      sum += *d;
    }
    return sum / static_cast<double>(pairs.size());
  };
  if (a.pixel_mm && b.pixel_mm) return mean_at(*a.pixel_mm, *b.pixel_mm);
  std::optional<double> least;
  for (int slide = -kFarthestSlide; slide <= kFarthestSlide; ++slide) {
    const std::optional<double> d = mean_at(1.0, std::exp2(0.5 * slide));
    if (d && (!least || *d < *least)) least = d;
  }
  return least;
}

std::optional<double> rates_between(const SurfaceDescriptor& a, const SurfaceDescriptor& b) {
  if (a.times.size() == 1 || b.times.size() == 1 || (a.onset.empty() && b.onset.empty())) return std::nullopt;
  if (a.onset.empty() || b.onset.empty()) return 1.0;
  return 0.5 * (quantile_distance(a.onset, kOnce, b.onset, kOnce, 1).value_or(1.0) +
                quantile_distance(a.saturation, kOnce, b.saturation, kOnce, 1).value_or(1.0));
}

double colors_between(const SortedColors& a, const SortedColors& b) {
  return sliced_distance(a, kOnce, b, kOnce).value_or(0.0);  // Both have colors.
}

}  // namespace

SurfaceDescriptor describe_surface(const TextureSeries& series, const RunControl& control) {
  SurfaceDescriptor out{.name = series.name(),
                        .times = moments_of(series.facts()),
                        .colors = {},
                        .spectra = {},
                        .pixel_mm = {},
                        .onset = {},
                        .saturation = {}};
  const int side = std::min(kDescribedSide_px, std::max(series.width(), series.height()));
  const ColorStack stack = load_stack(series, out.times, side, control.part(0.0, 0.5));
  out.pixel_mm = stack.pixel_mm;
  std::vector<std::uint32_t> all(stack.num_texels());
  std::iota(all.begin(), all.end(), 0U);
  const BlockGrid whole = make_blocks(stack, 1);
  struct Moment {
    std::optional<SortedColors> colors;
    Spectrum spectrum;
  };
  std::vector<Moment> moments(out.times.size());
  parallel_for(static_cast<std::int64_t>(moments.size()), 1, control.part(0.5, 0.9),
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
                   moments[t].colors.emplace(stack, t, all, whole.block_of, kMaxColors, 0);
                   const SpatialStructure structure(stack, t, whole, SpatialFigures::Spectrum);
                   moments[t].spectrum = {structure.frequencies(), structure.spectrum(kOnce)};
                 }
               });
  for (Moment& moment : moments) {
    out.colors.push_back(std::move(*moment.colors));
    out.spectra.push_back(std::move(moment.spectrum));
  }
  if (out.times.size() > 1) {
    const TexelAging aging = texel_aging(stack, CompareOptions{}.visible_delta_e, control.part(0.9, 1.0));
    out.onset = sorted_shares(aging.onset, aging.ages, out.times.front(), out.times.back());
    out.saturation = sorted_shares(aging.saturation, aging.ages, out.times.front(), out.times.back());
  }
  control.report(1.0);
  return out;
}

Dissimilarity dissimilarity(const SurfaceDescriptor& mine, const SurfaceDescriptor& other) {
  Dissimilarity out;
  std::vector<std::array<std::size_t, 2>> pairs;
  if (mine.times.size() == other.times.size()) {
    for (std::size_t i = 0; i < mine.times.size(); ++i) {
      pairs.push_back({i, i});
      out.colors += colors_between(mine.colors[i], other.colors[i]) / static_cast<double>(mine.times.size());
    }
    out.time = other.times.front();
  } else {  // A photograph against a history, or a history against one.
    std::optional<double> least;
    for (std::size_t i = 0; i < mine.times.size(); ++i) {
      for (std::size_t j = 0; j < other.times.size(); ++j) {
        const double d = colors_between(mine.colors[i], other.colors[j]);
        if (least && d >= *least) continue;
        least = d;
        pairs = {{i, j}};
      }
    }
    out.colors = least.value_or(0.0);
    out.time = other.times[pairs.front()[1]];
  }
  out.structure = structure_between(mine, other, pairs);
  out.rates = rates_between(mine, other);
  out.total =
      out.colors / kClearColors + out.structure.value_or(0.0) / kClearStructure + out.rates.value_or(0.0) / kClearRates;
  return out;
}

}  // namespace patinate::analysis
