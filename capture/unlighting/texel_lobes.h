/// \file
/// What one texel's samples say of a lobe, with its albedo and normal eliminated. Inside of unlighting only.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <numbers>
#include <span>
#include <vector>

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

/// About a seventh apart; between them a parabola.
inline constexpr std::array<double, 12> kLobeRoughness{0.15, 0.2,  0.25, 0.3,  0.35, 0.4,
                                                       0.46, 0.53, 0.6,  0.68, 0.78, 0.9};
inline constexpr int kNumLobeRoughness = static_cast<int>(kLobeRoughness.size());
/// Share of a lobe's square that albedo and normal must leave: one that diffuse light with another normal explains all
/// but this of, under these lamps, tells nothing.
inline constexpr double kMinOwn = 0.05;
inline constexpr double kSignificantGain = 30.0;  ///< Fall of chi-square; 5.5 standard deviations.

/// Sums of one texel: for each roughness, the lobe's square and its product with the samples, diffuse light eliminated.
struct LobeSums {
  std::array<double, kNumLobeRoughness> lobe_lobe{};
  std::array<double, kNumLobeRoughness> lobe_value{};
  std::array<double, kNumLobeRoughness> whole_lobe{};  ///< Its square before anything is eliminated.
};

/// Lobe with a strength for each channel: strengths s lower chi-square by 2 s . value - s . lobe s.
struct ChannelLobe {
  Eigen::Matrix3d lobe = Eigen::Matrix3d::Zero();
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Vector3d whole = Eigen::Vector3d::Zero();  ///< Squares before anything is eliminated.
  void add(double weight, const ChannelLobe& other) {
    lobe += weight * other.lobe;
    value += weight * other.value;
    whole += weight * other.whole;
  }
  [[nodiscard]] double gain(const Eigen::Vector3d& strength) const {
    return 2.0 * strength.dot(value) - strength.dot(lobe * strength);
  }
};

/// Evidence of a texel about lobes under two suppositions: with albedos of its own, and with none, as metal.
struct TexelEvidence {
  int x = 0, y = 0;
  int step = 0;                            ///< Number of the step among several that are looked at together.
  double matt = 0.0, black = 0.0;          ///< Chi-square without a lobe, albedos free or 0; at the best normal.
  std::vector<ChannelLobe> glossy, metal;  ///< For each roughness, albedos free or 0.
  int num_values = 0;                      ///< Lamps times channels.
  Eigen::Vector3d albedo = Eigen::Vector3d::Zero();  ///< That fits best without a lobe.
  std::vector<Eigen::Matrix3d> albedo_less;          ///< For each roughness: by strengths of a lobe.
  Eigen::Vector3d color = Eigen::Vector3d::Zero();   ///< Color of a matte fit: shares of red and green, and a little of
                                                     ///< how light it is.

  /// Whether albedos would have to be below 0 beside a lobe.
  [[nodiscard]] bool is_black_beside(const Eigen::Vector3d& strength, std::size_t roughness) const {
    return (albedo - albedo_less[roughness] * strength).sum() < 0.0;
  }
};

/// Unknowns that a texel's light is linear in: three albedos and the normal's two turns.
using Unknowns = Eigen::Matrix<double, 5, 1>;
using Normals = Eigen::Matrix<double, 5, 5>;
using Channels = Eigen::Matrix<double, 3, 1>;

/// One lamp's part; unused channels are 0.
struct LobeSample {
  Eigen::Matrix<double, 3, 5> slope = Eigen::Matrix<double, 3, 5>::Zero();  ///< Slope of the values by the unknowns.
  Channels value = Channels::Zero();                                        ///< Less the diffuse light.
  Channels whole = Channels::Zero();   ///< With it, less what comes from all around.
  Channels off = Channels::Zero();     ///< Less the highlight of the last fit too.
  Channels weight = Channels::Zero();  ///< 1 / variance.
  Channels light = Channels::Zero();   ///< Lobes times this are the sample.
  Vec3 direction = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< Normal by the other samples: one that follows this sample's noise would find a lobe
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
    for (std::size_t r = 0; r < kLobeRoughness.size(); ++r) {
      double ll = 0.0, lv = 0.0;
      Unknowns diffuse_lobe = Unknowns::Zero();
      for (const LobeSample& s : samples_) {
        const Channels lobe = specular_lobe(form_, s.normal, s.direction, to_camera, kLobeRoughness[r]) * s.light,
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

  /// @param roughness  Of the lobes that are asked of. @returns false where too little is known.
  bool evidence(int x, int y, const UnlightResult& fitted, std::span<const double> roughness, TexelEvidence& out);

 private:
  /// Prior of the turns, from the scan's normal; and of albedos that nothing tells.
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
    // Strengths by channel are asked of lobes without a tint.
    const std::array<double, 3> tint =
        form_.is_rendered ? std::array<double, 3>{1.0, 1.0, 1.0} : work_.tint(form_.tint, x, y);
    if (texel_.highlight.strength > 0.0 && !fitted.specular.empty())
      texel_.highlight.strength = static_cast<double>(fitted.specular.at(x, y, 0));
    for (int k = 0; k < work_.num_lights; ++k) {
      const auto state = static_cast<SampleState>(fitted.samples.at(x, y, k));
      if (state != SampleState::Clean && state != SampleState::Brighter) continue;
      LobeSample s{.direction = texel_.direction[k], .normal = n, .is_clean = state == SampleState::Clean};
      const double cosine = std::max(0.0, n.dot(s.direction));
      const TexelHighlight& h = texel_.highlight;
      const SpecularTurn turn = h.strength > 0.0
                                    ? specular_turn(h.form, n, tangents_, s.direction, h.to_camera, h.roughness)
                                    : SpecularTurn{};
      for (int c = 0; c < channels; ++c) {
        const auto i = texel_.index(k, c);
        const double a = static_cast<double>(fitted.albedo.at(x, y, c)),
                     unit = texel_.irradiance[i] * cosine + texel_.ambient[i];
        s.slope(c, c) = unit;
        const double shine = h.strength * h.tint[c] * texel_.irradiance[i] * std::numbers::pi;
        const double highlight = shine * turn.value;
        for (int t = 0; t < 2; ++t) {
          const Vec3& tangent = tangents_[t];
          s.slope(c, 3 + t) = a * texel_.irradiance[i] * tangent.dot(s.direction);
          if (highlight > 0.0) s.slope(c, 3 + t) += shine * turn.slope[t];
        }
        s.value[c] = texel_.value[i] - a * unit;
        s.whole[c] = texel_.value[i];
        s.off[c] = s.value[c] - highlight;
        s.light[c] = texel_.irradiance[i] * std::numbers::pi * tint[c];
        // Values predicted by the last fit are used: weights that follow the noise of the values would look like a
        // faint highlight.
        const double uncertain = work_.highlight_off * highlight;
        s.weight[c] = 1.0 / (work_.variance_of(a * unit + highlight) * fit_.noise_scale * fit_.noise_scale +
                             uncertain * uncertain);
      }
      samples_.push_back(s);
    }
  }

  static constexpr double kMaxTurn = 0.3;  ///< rad that a normal moves in a step.

  const UnlightWork& work_;
  SpecularForm form_;
  TexelFitOptions fit_;
  TexelSamples texel_;
  std::vector<LobeSample> samples_;
  std::array<Vec3, 2> tangents_{};  ///< Across the fitted normal.
};

}  // namespace patinate::capture
