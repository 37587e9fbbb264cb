#include "capture/unlighting/texel_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libcommon/core/median.h"

namespace patinate::capture {

namespace {

constexpr int kMaxChannels = 3;  ///< RGB.

/// Two unit vectors that span the plane across `n`.
std::array<Vec3, 2> tangent_pair(const Vec3& n) {
  const Vec3 axis = std::abs(n.x()) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 t = n.cross(axis).normalized();
  return {t, n.cross(t)};
}

/// @tparam Shared  Unknowns that all channels share: the normal's two turns; and 3 with the gain of a highlight.
template <int Shared>
class TexelSolver {
  using Vector = Eigen::Matrix<double, Shared, 1>;
  using Matrix = Eigen::Matrix<double, Shared, Shared>;
  static constexpr bool kHasHighlight = Shared == 3;

 public:
  TexelSolver(TexelSamples& samples, const TexelFitOptions& options)
      : s_(samples),
        o_(options),
        scale2_(options.noise_scale * options.noise_scale),
        weight_(samples.state.size(), 0.0),
        lobe_(kHasHighlight ? samples.state.size() : 0, Lobe{}) {
    normal_ = s_.normal;
    gain_prior_ = 1.0 / (s_.highlight.freedom * s_.highlight.freedom);
    black_ = s_.highlight.black_precision();
    has_prior_ = o_.refine_normal && std::isfinite(o_.normal_sigma);
    if (has_prior_)
      prior_ = 2.0 / (o_.normal_sigma * o_.normal_sigma);  // An angle of sigma is sigma / sqrt(2) along each tangent.
  }

  TexelFit solve() {
    candidates_.clear();
    for (int k = 0; k < s_.num_lights; ++k) {
      if (state(k) == SampleState::Clean) candidates_.push_back(k);
    }
    if (static_cast<int>(candidates_.size()) < least()) return {.normal = s_.normal};
    set_all_weights(1.0);
    shine();
    start();
    if (o_.reject) reject_outliers();
    constexpr int kMaxSteps = 20;  // It ends earlier where the fit rests.
    for (int i = 0; i < kMaxSteps; ++i) {
      if (step() < o_.small_step) break;
    }
    return result();
  }

 private:
  [[nodiscard]] SampleState& state(int k) { return s_.state[k]; }
  [[nodiscard]] double& weight(int k) { return weight_[k]; }
  [[nodiscard]] int least() const { return std::max(o_.min_lights, o_.refine_normal && !has_prior_ ? 3 : 1); }
  [[nodiscard]] double cosine(int k) const { return normal_.dot(s_.direction[k]); }
  /// Value that a texel of albedo 1 shows.
  [[nodiscard]] double unit_value(int k, int c) const {
    return s_.irradiance[s_.index(k, c)] * std::max(0.0, cosine(k)) + s_.ambient[s_.index(k, c)];
  }
  /// Value that a lamp shows beside the diffuse light.
  [[nodiscard]] double highlight(int k, int c) const {
    if constexpr (kHasHighlight) return gain_ * lobe_[k].value * shine_of(k, c);
    return 0.0;
  }
  /// Value that a lobe of 1 adds.
  [[nodiscard]] double shine_of(int k, int c) const {
    return s_.highlight.tint[c] * s_.irradiance[s_.index(k, c)] * std::numbers::pi;
  }
  [[nodiscard]] double off(int k, int c) const {
    return s_.value[s_.index(k, c)] - albedo_[c] * unit_value(k, c) - highlight(k, c);
  }

  /// Lobes under the normal, and how they change when it turns.
  void shine() {
    if constexpr (kHasHighlight) {
      const std::array<Vec3, 2> t = tangent_pair(normal_);
      const TexelHighlight& h = s_.highlight;
      for (int k : candidates_) {
        const Vec3& l = s_.direction[k];
        const SpecularTurn turn = specular_turn(h.form, normal_, t, l, h.to_camera, h.roughness);
        Lobe& at = lobe_[k];
        at.value = h.strength * turn.value;
        at.slope = {h.strength * turn.slope[0], h.strength * turn.slope[1]};
      }
    }
  }

  [[nodiscard]] double precision(int k, int c) const { return 1.0 / (scale2_ * s_.variance[s_.index(k, c)]); }

  void set_all_weights(double w) {
    for (int k : candidates_) weight(k) = w;
  }

  /// The albedos under the starting normal: medians, or (without rejection) least squares.
  void start() {
    for (int c = 0; c < s_.num_channels; ++c) {
      double& albedo = albedo_[c];
      if (!o_.reject) {
        albedo = least_squares_albedo(c);
        continue;
      }
      ratios_.clear();
      for (int k : candidates_) {
        const double unit = unit_value(k, c);
        if (unit > 0.0) ratios_.push_back((s_.value[s_.index(k, c)] - highlight(k, c)) / unit);
      }
      albedo = ratios_.empty() ? 0.0 : value_at_rank(ratios_, (ratios_.size() - 1) / 2);
    }
  }

  [[nodiscard]] double least_squares_albedo(int c) {
    double sum = 0.0, norm = 0.0;
    for (int k : candidates_) {
      const double unit = unit_value(k, c), w = weight(k) * precision(k, c);
      sum += w * unit * (s_.value[s_.index(k, c)] - highlight(k, c));
      norm += w * unit * unit;
    }
    return norm > 0.0 ? sum / norm : 0.0;
  }

  /// Residual of a lamp in standard deviations over all channels, with the sign of their sum: a lamp is shadowed in all
  /// of them.
  [[nodiscard]] double residual(int k) const {
    double sum = 0.0, squares = 0.0;
    for (int c = 0; c < s_.num_channels; ++c) {
      const double r = off(k, c) * std::sqrt(precision(k, c));
      sum += r;
      squares += r * r;
    }
    return std::copysign(std::sqrt(squares / s_.num_channels), sum);
  }

  void reject_outliers() {
    // Factor of the robust width from round to round (graduated non-convexity).
    constexpr double kShrink = 1.6;
    const double least = o_.rejection_width();
    double worst = 0.0;
    for (int k : candidates_) worst = std::max(worst, std::abs(residual(k)));
    for (double width = std::max(0.7 * worst, least); width > least; width = std::max(width / kShrink, least)) {
      weigh(width);
      step();
    }
    for (int i = 0; i < 3; ++i) {
      weigh(least);
      step();
    }
    constexpr int kRounds = 4;  // Rounds of clean samples and fit.
    for (int round = 0; round < kRounds; ++round) {
      if (!keep_near() || step() < o_.small_step) break;
      step();
    }
  }

  /// Geman and McClure's weights.
  void weigh(double width) {
    for (int k : candidates_) {
      const double r = residual(k) / width, w = 1.0 / (1.0 + r * r);
      weight(k) = w * w;
    }
  }

  /// Weight 1 for samples within rejection_sigma, else 0. @returns false when nothing changed.
  bool keep_near() {
    bool has_changed = false;
    for (int k : candidates_) {
      const double r = residual(k);
      const bool is_near = std::abs(r) <= o_.rejection_width();
      const SampleState now = is_near ? SampleState::Clean : r > 0.0 ? SampleState::Brighter : SampleState::Darker;
      const double w = is_near ? 1.0 : 0.0;
      has_changed = has_changed || now != state(k) || w != weight(k);
      state(k) = now;
      weight(k) = w;
    }
    return has_changed;
  }

  /// Sums of the normal equations; albedo rows are diagonal.
  struct Equations {
    std::array<double, kMaxChannels> aa{}, ga{};
    std::array<Vector, kMaxChannels> an;
    Matrix nn = Matrix::Zero();
    Vector gn = Vector::Zero();
  };

  [[nodiscard]] Equations equations(const std::array<Vec3, 2>& t) {
    Equations e;
    e.an.fill(Vector::Zero());
    for (int k : candidates_) {
      if (!(weight(k) > 0.0)) continue;
      const Vec3& l = s_.direction[k];
      const bool is_lit = cosine(k) > 0.0;
      const Eigen::Vector2d across = is_lit ? Eigen::Vector2d(l.dot(t[0]), l.dot(t[1])) : Eigen::Vector2d(0, 0);
      for (int c = 0; c < s_.num_channels; ++c) {
        const auto i = static_cast<std::size_t>(c);
        const double unit = unit_value(k, c), w = weight(k) * precision(k, c);
        const double r = off(k, c);
        Vector slope = Vector::Zero();
        slope.template head<2>() = albedo_[i] * s_.irradiance[s_.index(k, c)] * across;
        if constexpr (kHasHighlight) {
          const Lobe& lobe = lobe_[k];
          slope.template head<2>() += gain_ * shine_of(k, c) * lobe.slope;
          slope[2] = shine_of(k, c) * lobe.value;
        }
        e.aa[i] += w * unit * unit;
        e.ga[i] += w * unit * r;
        e.an[i] += w * unit * slope;
        e.nn += w * slope * slope.transpose();
        e.gn += w * r * slope;
      }
    }
    if constexpr (kHasHighlight) {
      for (std::size_t c = 0; c < static_cast<std::size_t>(s_.num_channels) && black_ > 0.0; ++c) {
        e.aa[c] += black_;
        e.ga[c] -= black_ * albedo_[c];
      }
    }
    return e;
  }

  /// With the albedos eliminated, and what is known beforehand.
  [[nodiscard]] Matrix reduced(const Equations& e) const {
    Matrix m = e.nn;
    for (int c = 0; c < s_.num_channels; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (e.aa[i] > 0.0) m -= e.an[i] * e.an[i].transpose() / e.aa[i];
    }
    if (has_prior_) m.template topLeftCorner<2, 2>() += prior_ * Eigen::Matrix2d::Identity();
    m += (1e-12 * e.nn.trace() + std::numeric_limits<double>::min()) * Matrix::Identity();
    if constexpr (kHasHighlight) {
      m(2, 2) += gain_prior_;
      if (!o_.refine_normal) {
        m.template topLeftCorner<2, 2>().setIdentity();
        m.template topRightCorner<2, 1>().setZero();
        m.template bottomLeftCorner<1, 2>().setZero();
      }
    }
    return m;
  }

  /// Step of the unknowns that channels share.
  [[nodiscard]] Vector shared_step(const Equations& e, const std::array<Vec3, 2>& t) const {
    if (!kHasHighlight && !o_.refine_normal) return Vector::Zero();
    Vector g = e.gn;
    for (int c = 0; c < s_.num_channels; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (e.aa[i] > 0.0) g -= e.an[i] * (e.ga[i] / e.aa[i]);
    }
    if (has_prior_) g.template head<2>() += prior_ * Eigen::Vector2d(s_.normal.dot(t[0]), s_.normal.dot(t[1]));
    if constexpr (kHasHighlight) {
      g[2] += gain_prior_ * (1.0 - gain_);
      if (!o_.refine_normal) g.template head<2>().setZero();
    }
    Vector turn = reduced(e).inverse() * g;
    constexpr double kMaxTurn = 0.3;  // rad that a normal moves in a step.
    if (!turn.allFinite()) turn.setZero();
    if (turn.norm() > kMaxTurn) turn *= kMaxTurn / turn.norm();
    return turn;
  }

  /// One Gauss-Newton step. @returns how far it went: turn of the normal plus the share of the albedo.
  double step() {
    const std::array<Vec3, 2> t = tangent_pair(normal_);
    const Equations e = equations(t);
    const Vector turn = shared_step(e, t);
    double change = turn.norm(), largest = 0.0, moved = 0.0;
    for (int c = 0; c < s_.num_channels; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const double d = e.aa[i] > 0.0 ? (e.ga[i] - e.an[i].dot(turn)) / e.aa[i] : 0.0;
      albedo_[i] += d;
      moved = std::max(moved, std::abs(d));
      largest = std::max(largest, std::abs(albedo_[i]));
    }
    normal_ = (normal_ + turn.x() * t[0] + turn.y() * t[1]).normalized();
    if constexpr (kHasHighlight) gain_ = std::clamp(gain_ + turn[2], 0.0, 2.0);
    shine();
    if (largest > 0.0) change += moved / largest;
    return change;
  }

  TexelFit result() {
    TexelFit fit{.normal = normal_, .gain = gain_};
    double num_values = 0.0;
    for (int k : candidates_) {
      if (!(weight(k) > 0.0)) continue;
      ++fit.num_clean;
      const double r = residual(k);
      fit.chi2 += r * r * s_.num_channels;
      num_values += s_.num_channels;
    }
    const Equations e = equations(tangent_pair(normal_));
    Matrix spread = reduced(e).inverse();
    double num_parameters = s_.num_channels;
    if (o_.refine_normal)
      num_parameters += 2.0 - (has_prior_ ? prior_ * spread.template topLeftCorner<2, 2>().trace() : 0.0);
    else
      spread.template topLeftCorner<2, 2>().setZero();
    if constexpr (kHasHighlight) num_parameters += 1.0 - gain_prior_ * spread(2, 2);
    fit.degrees_of_freedom = num_values - num_parameters;
    const double excess = fit.degrees_of_freedom > 0.5 ? std::max(1.0, fit.chi2 / fit.degrees_of_freedom) : 1.0;
    bool is_finite = normal_.allFinite();
    for (int c = 0; c < s_.num_channels; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (!(e.aa[i] > 0.0)) return {.normal = s_.normal};
      double variance = 1.0 / e.aa[i];
      if (kHasHighlight || o_.refine_normal) {
        const Vector per_turn = e.an[i] / e.aa[i];
        variance += per_turn.dot(spread * per_turn);
      }
      fit.albedo[i] = std::max(0.0, albedo_[i]);
      fit.stddev[i] = std::sqrt(excess * variance);
      is_finite = is_finite && std::isfinite(fit.albedo[i]) && std::isfinite(fit.stddev[i]);
    }
    fit.is_determined = is_finite && fit.num_clean >= least();
    if (!is_finite) return {.normal = s_.normal};
    return fit;
  }

  struct Lobe {
    double value = 0.0;
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  };

  TexelSamples& s_;
  const TexelFitOptions& o_;
  double scale2_;
  std::vector<double> weight_;
  std::vector<Lobe> lobe_;
  double gain_ = 1.0;
  double gain_prior_ = 0.0;
  double black_ = 0.0;
  std::vector<int> candidates_;
  std::vector<double> ratios_;
  std::array<double, kMaxChannels> albedo_{};
  Vec3 normal_;
  bool has_prior_ = false;
  double prior_ = 0.0;
};

}  // namespace

void TexelSamples::resize(int lights, int channels) {
  num_lights = lights;
  num_channels = channels;
  const auto l = static_cast<std::size_t>(lights), n = l * static_cast<std::size_t>(channels);
  direction.resize(l);
  state.resize(l);
  irradiance.resize(n);
  ambient.resize(n);
  value.resize(n);
  variance.resize(n);
}

double highlight_value(const TexelSamples& samples, int light, int channel, const Vec3& normal) {
  const TexelHighlight& h = samples.highlight;
  if (!(h.strength > 0.0)) return 0.0;
  return h.strength * specular_lobe(h.form, normal, samples.direction[light], h.to_camera, h.roughness) *
         h.tint[channel] * samples.irradiance[samples.index(light, channel)] * std::numbers::pi;
}

double highlight_share(const TexelSamples& samples, const TexelFit& fit, int channel) {
  const double albedo = fit.albedo[channel];
  double sum = 0.0, norm = 0.0;
  for (int k = 0; k < samples.num_lights; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (samples.state[i] != SampleState::Clean) continue;
    const double unit = samples.irradiance[samples.index(k, channel)] *
                            std::max(0.0, fit.normal.dot(samples.direction[i])) +
                        samples.ambient[samples.index(k, channel)],
                 weight = unit / samples.variance[samples.index(k, channel)];
    sum += weight * fit.gain * highlight_value(samples, k, channel, fit.normal);
    norm += weight * unit;
  }
  return norm > 0.0 && albedo > 0.0 ? sum / (norm * albedo) : 0.0;
}

TexelFit fit_texel(TexelSamples& samples, const TexelFitOptions& options) {
  if (samples.highlight.strength > 0.0) return TexelSolver<3>(samples, options).solve();
  return TexelSolver<2>(samples, options).solve();
}

}  // namespace patinate::capture
