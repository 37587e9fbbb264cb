/// \file
/// How alike two materials age, whatever was photographed how: by what they look like, how coarse they are, and when
/// their places change. For finding a history among many; `compare` says more of two.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/figures/block_values.h"
#include "analysis/figures/sliced_distance.h"
#include "analysis/figures/spectrum_distance.h"
#include "patinate/analysis/texture_series.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// Descriptor of a history or a photograph (a history of one frame).
struct SurfaceDescriptor {
  std::string name;
  std::vector<double> times;         ///< Moments evenly spread over its span; one for a photograph.
  std::vector<SortedColors> colors;  ///< At the moments.
  std::vector<Spectrum> spectra;     ///< Spectra of L* at the moments; without power where the surface is too small.
  std::optional<double> pixel_mm;    ///< Pixel size of the spectra.
  /// When places that age visibly begin and end to, as shares of the span, sorted; empty where none does.
  std::vector<BlockValue> onset, saturation;
};

inline constexpr int kDescribedSide_px = 256;       ///< Longer side at which a surface is described, at most.
inline constexpr std::size_t kDescribedTimes = 17;  ///< Moments.

/// @throws InvalidInput, IoError. Same bits for any number of threads.
[[nodiscard]] SurfaceDescriptor describe_surface(const TextureSeries& series, const RunControl& control = {});

/// How far apart two surfaces are.
struct Dissimilarity {
  /// Between the distributions of color, Delta E 1976: mean over equal shares of both spans. Of a photograph: at the
  /// moment that is nearest to it.
  double colors = 0.0;
  /// Between the power spectra at the same moments, octaves; nothing where a surface is too small for a spectrum.
  std::optional<double> structure;
  /// Between the distributions of onset and saturation (mean of both), in shares of the span; 1 where only one of the
  /// two ages. Nothing for a photograph, or where neither ages.
  std::optional<double> rates;
  double total = 0.0;  ///< The parts in units in which each is a clear difference: kClearColors and so on, added.
  double time = 0.0;   ///< Time of the other: the moment that is nearest to a photograph; else its beginning.
};
inline constexpr double kClearColors = 10.0;    ///< Delta E: another color to anybody.
inline constexpr double kClearStructure = 1.0;  ///< Twice or half the power.
inline constexpr double kClearRates = 0.1;      ///< A tenth of the span.

/// Where the size of a pixel is not known on both sides, spectra are slid over each other by up to two octaves: a
/// material photographed from another distance is the same. @param mine  Of a history or a photograph.
/// @param other  Of a history. A smaller total is more alike; 0 only for equal ones.
[[nodiscard]] Dissimilarity dissimilarity(const SurfaceDescriptor& mine, const SurfaceDescriptor& other);

}  // namespace patinate::analysis
