#include "capture/unlighting/specular_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "capture/unlighting/specular_tiles.h"
#include "libcommon/core/parallel.h"
#include "libcommon/image/filters.h"
#include "patinate/capture/unlight.h"

namespace patinate::capture {

namespace {

constexpr std::array<double, 12> kRoughness{0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.46, 0.53, 0.6, 0.68, 0.78, 0.9};
constexpr int kNumRoughness = static_cast<int>(kRoughness.size());
/// Of one texel: for each roughness, the lobe's square and its product with the samples, diffuse light eliminated.
struct LobeSums {
  std::array<double, kNumRoughness> lobe_lobe{};
  std::array<double, kNumRoughness> lobe_value{};
  std::array<double, kNumRoughness> whole_lobe{};  ///< Its square before anything is eliminated.
};

/// What a texel's light is linear in: three albedos and the normal's two turns.
using Unknowns = Eigen::Matrix<double, 5, 1>;
using Normals = Eigen::Matrix<double, 5, 5>;
using Channels = Eigen::Matrix<double, 3, 1>;

/// One lamp's part; unused channels are 0.
struct LobeSample {
  Eigen::Matrix<double, 3, 5> slope = Eigen::Matrix<double, 3, 5>::Zero();  ///< Of the values by the unknowns.
  Channels value = Channels::Zero();                                        ///< Less the diffuse light.
  Channels off = Channels::Zero();                                          ///< Less the highlight of the last fit too.
  Channels weight = Channels::Zero();                                       ///< 1 / variance.
  Channels light = Channels::Zero();                                        ///< Lobes times this are the sample.
  Vec3 direction = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< As the other samples have it: one that follows this sample's noise would find a lobe
                               ///< in it.
  bool is_clean = false;       ///< The fitted normal depends on it.
};

class TexelLobes {
 public:
  TexelLobes(const UnlightWork& work, const SpecularForm& form) : work_(work), form_(form), fit_(work.fit_options()) {}

  /// @returns false where too little is known.
  bool sum(int x, int y, const UnlightResult& fitted, LobeSums& sums) {
    gather(x, y, fitted);
    if (samples_.size() < 3) return false;
    const Vec3 to_camera = work_.to_camera(x, y);
    leave_each_out();
    Normals diffuse = prior();
    Unknowns diffuse_value = prior_pull();
    for (const LobeSample& s : samples_) {
      diffuse += s.slope.transpose() * s.weight.asDiagonal() * s.slope;
      diffuse_value += s.slope.transpose() * s.weight.cwiseProduct(s.value);
    }
    const Normals inverse = diffuse.inverse();
    if (!inverse.allFinite()) return false;
    for (std::size_t r = 0; r < kRoughness.size(); ++r) {
      double ll = 0.0, lv = 0.0;
      Unknowns diffuse_lobe = Unknowns::Zero();
      for (const LobeSample& s : samples_) {
        const Channels lobe = specular_lobe(form_, s.normal, s.direction, to_camera, kRoughness[r]) * s.light,
                       weighted = s.weight.cwiseProduct(lobe);
        ll += weighted.dot(lobe);
        lv += weighted.dot(s.value);
        diffuse_lobe += s.slope.transpose() * weighted;
      }
      const Unknowns projected = inverse * diffuse_lobe;
      sums.whole_lobe[r] = ll;
      sums.lobe_lobe[r] = std::max(0.0, ll - diffuse_lobe.dot(projected));
      sums.lobe_value[r] = lv - diffuse_value.dot(projected);
    }
    return true;
  }

 private:
  /// Of the turns, from the scan's normal; and of albedos that nothing tells.
  [[nodiscard]] Normals prior() const {
    Normals m = 1e-9 * Normals::Identity();
    m(3, 3) = m(4, 4) = turn_precision();
    return m;
  }
  [[nodiscard]] double turn_precision() const {
    if (!fit_.refine_normal) return 1e12;
    return std::isfinite(fit_.normal_sigma) ? 2.0 / (fit_.normal_sigma * fit_.normal_sigma) : 0.0;
  }
  [[nodiscard]] Unknowns prior_pull() const {
    Unknowns pull = Unknowns::Zero();
    if (!fit_.refine_normal) return pull;
    pull[3] = turn_precision() * texel_.normal.dot(tangents_[0]);
    pull[4] = turn_precision() * texel_.normal.dot(tangents_[1]);
    return pull;
  }

  /// Gives every clean sample the normal that the fit would have without it, to first order (its leverage and residual
  /// tell).
  void leave_each_out() {
    if (!fit_.refine_normal) return;
    Normals matrix = prior();
    for (const LobeSample& s : samples_) {
      if (s.is_clean) matrix += s.slope.transpose() * s.weight.asDiagonal() * s.slope;
    }
    const Normals inverse = matrix.inverse();
    if (!inverse.allFinite()) return;
    for (LobeSample& s : samples_) {
      if (!s.is_clean) continue;
      const Eigen::Matrix<double, 5, 3> pull = inverse * s.slope.transpose() * s.weight.asDiagonal();
      const Eigen::Matrix3d others = Eigen::Matrix3d::Identity() - s.slope * pull;
      const Unknowns shift = pull * (others.inverse() * s.off);
      const Vec3 turn = shift[3] * tangents_[0] + shift[4] * tangents_[1];
      if (turn.norm() < kMaxTurn) s.normal = (s.normal - turn).normalized();
    }
  }

  void gather(int x, int y, const UnlightResult& fitted) {
    samples_.clear();
    work_.load(x, y, texel_);
    const int channels = work_.num_channels;
    const Vec3 n = vector_of(fitted.normal, x, y);
    const Vec3 axis = std::abs(n.x()) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    tangents_[0] = n.cross(axis).normalized();
    tangents_[1] = n.cross(tangents_[0]);
    const std::array<double, 3> tint = work_.tint(form_.tint, x, y);
    if (texel_.highlight.strength > 0.0 && !fitted.specular.empty())
      texel_.highlight.strength = static_cast<double>(fitted.specular.at(x, y, 0));
    for (int k = 0; k < work_.num_lights; ++k) {
      const auto state = static_cast<SampleState>(fitted.samples.at(x, y, k));
      if (state != SampleState::Clean && state != SampleState::Brighter) continue;
      LobeSample s{.direction = texel_.direction[static_cast<std::size_t>(k)],
                   .normal = n,
                   .is_clean = state == SampleState::Clean};
      const double cosine = std::max(0.0, n.dot(s.direction));
      for (int c = 0; c < channels; ++c) {
        const auto i = texel_.index(k, c);
        const double a = static_cast<double>(fitted.albedo.at(x, y, c)),
                     unit = texel_.irradiance[i] * cosine + texel_.ambient[i];
        s.slope(c, c) = unit;
        const double highlight = highlight_value(texel_, k, c, n);
        for (int t = 0; t < 2; ++t) {
          const Vec3& tangent = tangents_[static_cast<std::size_t>(t)];
          s.slope(c, 3 + t) = a * texel_.irradiance[i] * tangent.dot(s.direction);
          if (highlight > 0.0) {
            const Vec3 turned = (n + kSmallTurn * tangent).normalized();
            s.slope(c, 3 + t) += (highlight_value(texel_, k, c, turned) - highlight) / kSmallTurn;
          }
        }
        s.value[c] = texel_.value[i] - a * unit;
        s.off[c] = s.value[c] - highlight;
        s.light[c] = texel_.irradiance[i] * std::numbers::pi * tint[static_cast<std::size_t>(c)];
        // Of what the last fit predicts: weights that follow the noise of the values would look like a faint highlight.
        const double uncertain = work_.highlight_off * highlight;
        s.weight[c] = 1.0 / (work_.variance_of(a * unit + highlight) * fit_.noise_scale * fit_.noise_scale +
                             uncertain * uncertain);
      }
      samples_.push_back(s);
    }
  }

  static constexpr double kMaxTurn = 0.3, kSmallTurn = 1e-4;

  const UnlightWork& work_;
  SpecularForm form_;
  TexelFitOptions fit_;
  TexelSamples texel_;
  std::vector<LobeSample> samples_;
  std::array<Vec3, 2> tangents_{};  ///< Across the fitted normal.
};

constexpr int kSums = 3;  ///< Of each roughness: channels kSums r ... of sums over tiles.

/// Sums over tiles: lobe_lobe, lobe_value and whole_lobe of every roughness.
ImageF tile_sums(const UnlightWork& work, const SpecularForm& form, const UnlightResult& fitted,
                 const RunControl& control) {
  const int columns = (work.width + kSpecularTile - 1) / kSpecularTile,
            rows = (work.height + kSpecularTile - 1) / kSpecularTile;
  ImageF tiles(columns, rows, kSums * kNumRoughness);
  parallel_for(rows, 1, control, [&](std::int64_t row, std::int64_t) {
    TexelLobes lobes(work, form);
    const int ty = static_cast<int>(row);
    std::vector<double> line(static_cast<std::size_t>(columns * kSums * kNumRoughness), 0.0);
    for (int y = ty * kSpecularTile; y < std::min(work.height, (ty + 1) * kSpecularTile); ++y) {
      for (int x = 0; x < work.width; ++x) {
        LobeSums sums;
        if (!is_specular_sample(x, y, work.highlight_step) || fitted.mask.at(x, y) == 0 ||
            !lobes.sum(x, y, fitted, sums))
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

/// One form of the lobe, for every tile.
struct TileLobes {
  ImageF tiles = {};  ///< x 2: strength, roughness.
  double gain = 0.0;  ///< What it explains of the samples' chi-square.
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
