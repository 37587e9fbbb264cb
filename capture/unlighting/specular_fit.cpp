#include "capture/unlighting/specular_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "capture/unlighting/specular_tiles.h"
#include "capture/unlighting/texel_lobes.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/capture/unlight.h"

namespace patinate::capture {

namespace {

constexpr int kSums = 3;  ///< Sums for each roughness: channels kSums r ... of sums over tiles.

/// Sums over tiles: lobe_lobe, lobe_value and whole_lobe of every roughness.
ImageF tile_sums(const UnlightWork& work, const SpecularForm& form, const UnlightResult& fitted,
                 const RunControl& control) {
  const int columns = (work.width + kSpecularTile - 1) / kSpecularTile,
            rows = (work.height + kSpecularTile - 1) / kSpecularTile;
  ImageF tiles(columns, rows, kSums * kNumLobeRoughness);
  parallel_for(rows, 1, control, [&](std::int64_t row, std::int64_t) {
    TexelLobes lobes(work, form);
    const int ty = static_cast<int>(row);
    std::vector<double> line(static_cast<std::size_t>(columns * kSums * kNumLobeRoughness), 0.0);
    for (int y = ty * kSpecularTile; y < std::min(work.height, (ty + 1) * kSpecularTile); ++y) {
      for (int x = 0; x < work.width; ++x) {
        LobeSums sums;
        if (!is_specular_sample(x, y, work.highlight_step) || fitted.mask.at(x, y) == 0 ||
            !lobes.sum(x, y, fitted, sums))
          continue;
        double* at = &line[x / kSpecularTile * kSums * kNumLobeRoughness];
        for (std::size_t r = 0; r < kLobeRoughness.size(); ++r) {
          at[kSums * r] += sums.lobe_lobe[r];
          at[kSums * r + 1] += sums.lobe_value[r];
          at[kSums * r + 2] += sums.whole_lobe[r];
        }
      }
    }
    std::transform(line.begin(), line.end(), tiles.row(ty).begin(), [](double v) { return static_cast<float>(v); });
  });
  return tiles;
}

struct BestLobe {
  double strength = 0.0;
  double roughness = 0.0;
  double gain = 0.0;  ///< Gain of chi-square.
};

/// Best lobe of a tile, from its smoothed sums: the roughness that explains most, between those of the series by a
/// parabola.
/// @param num_tiles  That the means were taken of: what noise alone explains is no highlight.
BestLobe best_lobe(std::span<const float> sums, double num_tiles) {
  std::array<double, kNumLobeRoughness> gain{}, strength{};
  std::size_t best = 0;
  for (std::size_t r = 0; r < kLobeRoughness.size(); ++r) {
    const auto ll = static_cast<double>(sums[kSums * r]), lv = static_cast<double>(sums[kSums * r + 1]),
               whole = static_cast<double>(sums[kSums * r + 2]);
    strength[r] = ll > kMinOwn * whole && ll > 0.0 ? std::clamp(lv / ll, 0.0, 1.0) : 0.0;
    gain[r] = strength[r] * std::max(0.0, lv);
    if (gain[r] > gain[best]) best = r;
  }
  if (!(gain[best] * num_tiles > kSignificantGain)) return {};
  if (best == 0 || best + 1 == kLobeRoughness.size()) return {strength[best], kLobeRoughness[best], gain[best]};
  const double left = gain[best - 1], mid = gain[best], right = gain[best + 1], bend = left - 2.0 * mid + right;
  const double shift = bend < 0.0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
  const std::size_t other = shift < 0.0 ? best - 1 : best + 1;
  const double share = std::abs(shift);
  return {strength[best] + share * (strength[other] - strength[best]),
          kLobeRoughness[best] + share * (kLobeRoughness[other] - kLobeRoughness[best]), gain[best]};
}

/// Between tiles' centers; tiles without a highlight have strength 0 and lend no roughness.
std::array<double, 2> interpolated(const ImageF& tiles, int x, int y) {
  double strength = 0.0, roughness = 0.0, weight = 0.0;
  for (const TileShare& tile : tiles_around(tiles, x, y)) {
    const auto tile_strength = static_cast<double>(tiles.at(tile.x, tile.y, 0));
    strength += tile.weight * tile_strength;
    if (!(tile_strength > 0.0)) continue;
    roughness += tile.weight * static_cast<double>(tiles.at(tile.x, tile.y, 1));
    weight += tile.weight;
  }
  return {strength, weight > 0.0 ? roughness / weight : 0.0};
}

/// One form of the lobe, for every tile.
struct TileLobes {
  ImageF tiles = {};  ///< x 2: strength, roughness.
  double gain = 0.0;  ///< Chi-square of the samples that it explains.
};

TileLobes fit_tiles(const UnlightWork& work, const SpecularForm& form, const UnlightResult& fitted,
                    const RunControl& control) {
  const double sigma = work.options.specular_window_px / kSpecularTile;
  const ImageF sums =
      gaussian_blur(tile_sums(work, form, fitted, control.part(0.0, 0.9)), sigma, control.part(0.9, 1.0));
  const double num_tiles =
      std::min(static_cast<double>(sums.num_pixels()), std::max(1.0, 4.0 * std::numbers::pi * sigma * sigma));
  TileLobes result{.tiles = ImageF(sums.width(), sums.height(), 2)};
  for (int y = 0; y < sums.height(); ++y) {
    for (int x = 0; x < sums.width(); ++x) {
      const BestLobe best = best_lobe(sums.pixel(x, y), num_tiles);
      result.tiles.at(x, y, 0) = static_cast<float>(best.strength);
      result.tiles.at(x, y, 1) = static_cast<float>(best.roughness);
      result.gain += best.gain;
    }
  }
  return result;
}

}  // namespace

SpecularFit fit_specular(const UnlightWork& work, const UnlightResult& fitted, const SpecularForm& form,
                         const RunControl& control) {
  const TileLobes lobes = fit_tiles(work, form, fitted, control);
  SpecularFit result{.values = ImageF(work.width, work.height, 2), .gain = lobes.gain};
  for (int y = 0; y < work.height; ++y) {
    for (int x = 0; x < work.width; ++x) {
      if (!work.is_surface(x, y)) continue;
      const auto [strength, roughness] = interpolated(lobes.tiles, x, y);
      if (!(strength > 0.0)) continue;
      result.values.at(x, y, 0) = static_cast<float>(strength);
      result.values.at(x, y, 1) = static_cast<float>(roughness);
    }
  }
  return result;
}

void fit_highlights(UnlightWork& work, const UnlightResult& fitted, const RunControl& control) {
  ImageF specular = fit_specular(work, fitted, work.form, control).values;
  work.highlight_normal = fitted.normal;
  work.highlight_base = fitted.albedo;
  work.specular = std::move(specular);
}

}  // namespace patinate::capture
