#include "capture/unlighting/specular_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "capture/unlighting/specular_tiles.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/capture/unlight.h"

namespace patinate::capture {

namespace {

constexpr std::array<double, 12> kRoughness{0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.46, 0.53, 0.6, 0.68, 0.78, 0.9};
constexpr int kNumRoughness = static_cast<int>(kRoughness.size());
constexpr double kTexelFreedom =
    0.3;  ///< Standard deviation of a texel's strength about its neighborhood's, as a share of it.

/// Of one texel: for each roughness, the lobe's square and its product with the samples, diffuse light eliminated.
struct LobeSums {
  std::array<double, kNumRoughness> lobe_lobe{};
  std::array<double, kNumRoughness> lobe_value{};
  std::array<double, kNumRoughness> whole_lobe{};  ///< Its square before anything is eliminated.
};

/// One lamp's part: summed over channels, weighted by its variance.
struct LobeSample {
  Vec3 diffuse;  ///< Derivatives by albedo and by the normal's two turns.
  double value;
  double matt_value;  ///< Less the highlight, as the last fit had it.
  double matt_weight;
  double weight;
  double light;  ///< Lobes times this are the sample.
  Vec3 direction;
  Vec3 normal;    ///< As the other samples have it: one that follows this sample's noise would find a lobe in it.
  bool is_clean;  ///< The fitted normal depends on it.
};

class TexelLobes {
 public:
  TexelLobes(const UnlightWork& work, SpecularLobe lobe) : work_(work), lobe_(lobe), fit_(work.fit_options()) {}

  /// Of the roughnesses first, ..., last. @returns false where too little is known.
  bool sum(int x, int y, const UnlightResult& fitted, std::size_t first, std::size_t last, LobeSums& sums) {
    work_.load_raw(x, y, texel_);
    work_.load(x, y, matt_);
    gather(x, y, fitted);
    if (samples_.size() < 3) return false;
    const Vec3 to_camera = work_.to_camera(x, y);
    leave_each_out(vector_of(fitted.normal, x, y));
    Eigen::Matrix3d diffuse = prior();
    Vec3 diffuse_value = Vec3::Zero();
    for (const LobeSample& s : samples_) {
      diffuse += s.weight * s.diffuse * s.diffuse.transpose();
      diffuse_value += s.weight * s.value * s.diffuse;
    }
    const Eigen::Matrix3d inverse = diffuse.inverse();
    if (!inverse.allFinite()) return false;
    for (std::size_t r = first; r <= last; ++r) {
      double ll = 0.0, lv = 0.0;
      Vec3 diffuse_lobe = Vec3::Zero();
      for (const LobeSample& s : samples_) {
        const double lobe = s.light * specular_lobe(lobe_, s.normal, s.direction, to_camera, kRoughness[r]);
        ll += s.weight * lobe * lobe;
        lv += s.weight * lobe * s.value;
        diffuse_lobe += s.weight * lobe * s.diffuse;
      }
      const Vec3 projected = inverse * diffuse_lobe;
      sums.whole_lobe[r] = ll;
      sums.lobe_lobe[r] = std::max(0.0, ll - diffuse_lobe.dot(projected));
      sums.lobe_value[r] = lv - diffuse_value.dot(projected);
    }
    return true;
  }

 private:
  /// Of a change of the scan's normal, times the albedo.
  [[nodiscard]] Eigen::Matrix3d prior() const {
    Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
    if (!fit_.refine_normal) {
      m(1, 1) = m(2, 2) = 1e12;
    } else if (std::isfinite(fit_.normal_sigma)) {
      m(1, 1) = m(2, 2) = 2.0 / std::max(1e-12, fit_.normal_sigma * fit_.normal_sigma * albedo_ * albedo_);
    }
    return m;
  }

  /// Gives every clean sample the normal that the fit would have without it, to first order (its leverage and residual
  /// tell).
  void leave_each_out(const Vec3& fitted_normal) {
    if (!fit_.refine_normal) return;
    Eigen::Matrix3d matrix = prior();
    Vec3 right = Vec3::Zero();
    for (const LobeSample& s : samples_) {
      if (!s.is_clean) continue;
      matrix += s.matt_weight * s.diffuse * s.diffuse.transpose();
      right += s.matt_weight * s.matt_value * s.diffuse;
    }
    const Eigen::Matrix3d inverse = matrix.inverse();
    const Vec3 solution = inverse * right;
    if (!solution.allFinite() || !(solution.x() > 0.0)) return;
    for (LobeSample& s : samples_) {
      if (!s.is_clean) continue;
      const Vec3 pull = inverse * s.diffuse;
      const double leverage = s.matt_weight * s.diffuse.dot(pull);
      if (!(leverage < 0.99)) continue;
      const Vec3 shift = pull * (s.matt_weight * (s.matt_value - s.diffuse.dot(solution)) / (1.0 - leverage));
      const Vec3 turn = (shift.y() * tangent_ + shift.z() * bitangent_) / solution.x();
      if (turn.norm() < 0.3) s.normal = (fitted_normal - turn).normalized();
    }
  }

  void gather(int x, int y, const UnlightResult& fitted) {
    samples_.clear();
    albedo_ = 0.0;
    const int channels = work_.num_channels;
    std::array<double, 3> albedo{};
    for (int c = 0; c < channels; ++c) {
      albedo[static_cast<std::size_t>(c)] = static_cast<double>(fitted.albedo.at(x, y, c));
      albedo_ += albedo[static_cast<std::size_t>(c)];
    }
    if (!(albedo_ > 0.0)) albedo_ = 1e-6;
    const Vec3 fitted_normal = vector_of(fitted.normal, x, y);
    const Vec3& n = texel_.normal;
    const Vec3 axis = std::abs(n.x()) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    tangent_ = n.cross(axis).normalized();
    bitangent_ = n.cross(tangent_);
    for (int k = 0; k < work_.num_lights; ++k) {
      const auto state = static_cast<SampleState>(fitted.samples.at(x, y, k));
      if (state != SampleState::Clean && state != SampleState::Brighter) continue;
      LobeSample s{.diffuse = Vec3::Zero(),
                   .value = 0.0,
                   .matt_value = 0.0,
                   .matt_weight = 0.0,
                   .weight = 0.0,
                   .light = 0.0,
                   .direction = texel_.direction[static_cast<std::size_t>(k)],
                   .normal = fitted_normal,
                   .is_clean = state == SampleState::Clean};
      double facing = 0.0, variance = 0.0, matt_variance = 0.0;
      for (int c = 0; c < channels; ++c) {
        const auto i = texel_.index(k, c);
        const double a = albedo[static_cast<std::size_t>(c)];
        facing += texel_.irradiance[i] * a / albedo_;
        s.light += texel_.irradiance[i] * std::numbers::pi;
        matt_variance += matt_.variance[i];
        s.matt_value += matt_.value[i] - a * texel_.ambient[static_cast<std::size_t>(c)];
        s.value += texel_.value[i] - a * texel_.ambient[static_cast<std::size_t>(c)];
        // Of what the diffuse light predicts: weights that follow the noise of the values would look like a faint
        // highlight.
        variance += work_.variance_of(a * (texel_.irradiance[i] * std::max(0.0, fitted_normal.dot(s.direction)) +
                                           texel_.ambient[static_cast<std::size_t>(c)]));
      }
      s.diffuse = facing * Vec3(n.dot(s.direction), tangent_.dot(s.direction), bitangent_.dot(s.direction));
      s.matt_weight = 1.0 / (matt_variance * fit_.noise_scale * fit_.noise_scale);
      s.weight = 1.0 / (variance * fit_.noise_scale * fit_.noise_scale);
      samples_.push_back(s);
    }
  }

  const UnlightWork& work_;
  SpecularLobe lobe_;
  TexelFitOptions fit_;
  TexelSamples texel_;
  TexelSamples matt_;  ///< As the last fit had it.
  std::vector<LobeSample> samples_;
  Vec3 tangent_ = Vec3::Zero(), bitangent_ = Vec3::Zero();  ///< Across the scan's normal.
  double albedo_ = 0.0;
};

constexpr int kSums = 3;  ///< Of each roughness: channels kSums r ... of sums over tiles.

/// Sums over tiles: lobe_lobe, lobe_value and whole_lobe of every roughness.
ImageF tile_sums(const UnlightWork& work, SpecularLobe lobe, const UnlightResult& fitted, const RunControl& control) {
  const int columns = (work.width + kSpecularTile - 1) / kSpecularTile,
            rows = (work.height + kSpecularTile - 1) / kSpecularTile;
  ImageF tiles(columns, rows, kSums * kNumRoughness);
  parallel_for(rows, 1, control, [&](std::int64_t row, std::int64_t) {
    TexelLobes lobes(work, lobe);
    const int ty = static_cast<int>(row);
    std::vector<double> line(static_cast<std::size_t>(columns * kSums * kNumRoughness), 0.0);
    for (int y = ty * kSpecularTile; y < std::min(work.height, (ty + 1) * kSpecularTile); ++y) {
      for (int x = 0; x < work.width; ++x) {
        LobeSums sums;
        if (!is_specular_sample(x, y) || fitted.mask.at(x, y) == 0 ||
            !lobes.sum(x, y, fitted, 0, kRoughness.size() - 1, sums))
          continue;
        double* at = &line[static_cast<std::size_t>(x / kSpecularTile * kSums * kNumRoughness)];
        for (std::size_t r = 0; r < kRoughness.size(); ++r) {
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
  double gain = 0.0;  ///< Of chi-square.
};

/// Of a tile, from its smoothed sums: the roughness that explains most, between those of the series by a parabola.
/// @param num_tiles  That the means were taken of: what noise alone explains is no highlight.
BestLobe best_lobe(std::span<const float> sums, double num_tiles) {
  constexpr double kLeastOwn = 0.05;  // A lobe of which diffuse light with another normal explains all but this, under
                                      // these lamps, tells nothing.
  constexpr double kSignificant = 30.0;  // Of chi-square; 5.5 standard deviations.
  std::array<double, kNumRoughness> gain{}, strength{};
  std::size_t best = 0;
  for (std::size_t r = 0; r < kRoughness.size(); ++r) {
    const auto ll = static_cast<double>(sums[kSums * r]), lv = static_cast<double>(sums[kSums * r + 1]),
               whole = static_cast<double>(sums[kSums * r + 2]);
    strength[r] = ll > kLeastOwn * whole && ll > 0.0 ? std::clamp(lv / ll, 0.0, 1.0) : 0.0;
    gain[r] = strength[r] * std::max(0.0, lv);
    if (gain[r] > gain[best]) best = r;
  }
  if (!(gain[best] * num_tiles > kSignificant)) return {};
  if (best == 0 || best + 1 == kRoughness.size()) return {strength[best], kRoughness[best], gain[best]};
  const double left = gain[best - 1], mid = gain[best], right = gain[best + 1], bend = left - 2.0 * mid + right;
  const double shift = bend < 0.0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
  const std::size_t other = shift < 0.0 ? best - 1 : best + 1;
  const double share = std::abs(shift);
  return {strength[best] + share * (strength[other] - strength[best]),
          kRoughness[best] + share * (kRoughness[other] - kRoughness[best]), gain[best]};
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

/// Where a roughness lies in the series: after `below`, by `share` of the way to the next.
struct Place {
  std::size_t below = 0;
  double share = 0.0;
  [[nodiscard]] double between(const std::array<double, kNumRoughness>& sums) const {
    return sums[below] + share * (sums[below + 1] - sums[below]);
  }
};

Place place_of(double roughness) {
  std::size_t below = 0;
  while (below + 2 < kRoughness.size() && kRoughness[below + 1] <= roughness) ++below;
  return {below, std::clamp((roughness - kRoughness[below]) / (kRoughness[below + 1] - kRoughness[below]), 0.0, 1.0)};
}

/// One form of the lobe, for every tile.
struct TileLobes {
  ImageF tiles = {};  ///< x 2: strength, roughness.
  double gain = 0.0;  ///< What it explains of the samples' chi-square.
};

TileLobes fit_tiles(const UnlightWork& work, SpecularLobe lobe, const UnlightResult& fitted,
                    const RunControl& control) {
  const double sigma = work.options.specular_window_px / kSpecularTile;
  const ImageF sums =
      gaussian_blur(tile_sums(work, lobe, fitted, control.part(0.0, 0.9)), sigma, control.part(0.9, 1.0));
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

SpecularFit fit_specular(const UnlightWork& work, const UnlightResult& fitted, const RunControl& control) {
  const TileLobes ggx = fit_tiles(work, SpecularLobe::Ggx, fitted, control.part(0.0, 0.3));
  const TileLobes beckmann = fit_tiles(work, SpecularLobe::Beckmann, fitted, control.part(0.3, 0.6));
  SpecularFit result{.lobe = beckmann.gain > ggx.gain ? SpecularLobe::Beckmann : SpecularLobe::Ggx,
                     .values = ImageF(work.width, work.height, 2)};
  const ImageF& tiles = result.lobe == SpecularLobe::Ggx ? ggx.tiles : beckmann.tiles;
  parallel_for(work.height, 4, control.part(0.6, 1.0), [&](std::int64_t begin, std::int64_t end) {
    TexelLobes lobes(work, result.lobe);
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < work.width; ++x) {
        if (!work.is_surface(x, y)) continue;
        const auto [near_strength, roughness] = interpolated(tiles, x, y);
        if (!(near_strength > 0.0)) continue;
        double strength = near_strength;
        LobeSums own;
        const Place place = place_of(roughness);
        if (fitted.mask.at(x, y) != 0 && lobes.sum(x, y, fitted, place.below, place.below + 1, own)) {
          const double trust = 1.0 / (kTexelFreedom * kTexelFreedom * near_strength * near_strength);
          strength = (place.between(own.lobe_value) + trust * near_strength) / (place.between(own.lobe_lobe) + trust);
          strength = std::clamp(strength, 0.0, 2.0 * near_strength);
        }
        result.values.at(x, y, 0) = static_cast<float>(strength);
        result.values.at(x, y, 1) = static_cast<float>(roughness);
      }
    }
  });
  return result;
}

}  // namespace patinate::capture
