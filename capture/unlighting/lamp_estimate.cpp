#include "capture/unlighting/lamp_estimate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "libcommon/core/median.h"
#include "libcommon/core/parallel.h"
#include "libcommon/geometry/dense_solve.h"

namespace patinate::capture {

namespace {

constexpr std::int64_t kMaxLampTexels = 8'000, kLampTexelsAChunk = 256;  ///< See docs/algorithms/unlighting.md.
constexpr double kMinScale = 1e-4;                                       ///< Least noise; exact data would divide by 0.

/// Columns of the equations for strengths and ambients; -1 = it is known.
class Columns {
 public:
  explicit Columns(const UnlightWork& work)
      : channels_(work.num_channels),
        num_strengths_(work.options.estimate_strengths ? work.num_lights * work.num_channels : 0),
        num_ambient_(work.options.estimate_ambient ? work.num_channels : 0) {}
  [[nodiscard]] Eigen::Index strength(int light, int channel) const {
    return num_strengths_ > 0 ? light * channels_ + channel : -1;
  }
  [[nodiscard]] Eigen::Index ambient(int channel) const { return num_ambient_ > 0 ? num_strengths_ + channel : -1; }
  [[nodiscard]] Eigen::Index size() const { return num_strengths_ + num_ambient_; }

 private:
  int channels_, num_strengths_, num_ambient_;
};

/// Normal equations with the texels eliminated, and what texels say of the noise.
struct Equations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  std::vector<double> chi2;  ///< Over degrees of freedom and its median.
};

class TexelEquations {
 public:
  TexelEquations(const UnlightWork& work, const Columns& columns)
      : work_(work), columns_(columns), options_(work.fit_options()) {}

  void add(int x, int y, Equations& sums) {
    work_.load(x, y, texel_);
    const TexelFit fit = fit_texel(texel_, options_);
    if (!fit.is_determined) return;
    if (fit.degrees_of_freedom >= 1.0) {
      const double dof = fit.degrees_of_freedom;
      sums.chi2.push_back(fit.chi2 / (dof * std::pow(1.0 - 2.0 / (9.0 * dof), 3.0)));
    }
    const int channels = work_.num_channels;
    const Eigen::Index num_local = channels + 2, n = columns_.size();
    Eigen::MatrixXd local = Eigen::MatrixXd::Zero(num_local, num_local), mixed = Eigen::MatrixXd::Zero(num_local, n);
    Eigen::VectorXd local_right = Eigen::VectorXd::Zero(num_local);
    add_prior(fit, local, local_right);
    const auto [t, b] = across(fit.normal);
    Eigen::VectorXd row(num_local);
    for (int k = 0; k < work_.num_lights; ++k) {
      if (texel_.state[k] != SampleState::Clean) continue;
      const Vec3& l = texel_.direction[k];
      const double cosine = fit.normal.dot(l);
      if (!(cosine > 0.0)) continue;
      for (int c = 0; c < channels; ++c) {
        const auto i = texel_.index(k, c);
        const double albedo = fit.albedo[c], lit = texel_.irradiance[i] * cosine, ambient = texel_.ambient[i];
        const double w = 1.0 / (texel_.variance[i] * options_.noise_scale * options_.noise_scale);
        const double residual = texel_.value[i] - albedo * (lit + ambient);
        row.setZero();
        row[c] = lit + ambient;
        if (options_.refine_normal) {
          row[channels] = albedo * texel_.irradiance[i] * l.dot(t);
          row[channels + 1] = albedo * texel_.irradiance[i] * l.dot(b);
        }
        local += w * row * row.transpose();
        local_right += w * residual * row;
        const Eigen::Index columns[2] = {columns_.strength(k, c), columns_.ambient(c)};
        const double slopes[2] = {albedo * lit, albedo / std::numbers::pi};
        for (int i1 = 0; i1 < 2; ++i1) {
          if (columns[i1] < 0) continue;
          sums.right[columns[i1]] += w * residual * slopes[i1];
          mixed.col(columns[i1]) += w * slopes[i1] * row;
          for (int i2 = 0; i2 < 2; ++i2) {
            if (columns[i2] >= 0) sums.matrix(columns[i1], columns[i2]) += w * slopes[i1] * slopes[i2];
          }
        }
      }
    }
    const LdltFactors solver(local);
    if (!solver.is_factored()) return;
    sums.matrix -= mixed.transpose() * solver.solve(mixed);
    sums.right -= mixed.transpose() * solver.solve(local_right);
  }

 private:
  [[nodiscard]] static std::pair<Vec3, Vec3> across(const Vec3& n) {
    const Vec3 axis = std::abs(n.x()) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0), t = n.cross(axis).normalized();
    return {t, n.cross(t)};
  }

  void add_prior(const TexelFit& fit, Eigen::MatrixXd& local, Eigen::VectorXd& right) const {
    const Eigen::Index at = work_.num_channels;
    if (!options_.refine_normal) {
      local(at, at) = local(at + 1, at + 1) = 1.0;
      return;
    }
    local(at, at) = local(at + 1, at + 1) = 1e-12;
    if (!std::isfinite(options_.normal_sigma)) return;
    const double precision = 2.0 / (options_.normal_sigma * options_.normal_sigma);
    const auto [t, b] = across(fit.normal);
    local(at, at) += precision;
    local(at + 1, at + 1) += precision;
    right[at] += precision * texel_.normal.dot(t);
    right[at + 1] += precision * texel_.normal.dot(b);
  }

  const UnlightWork& work_;
  const Columns& columns_;
  TexelFitOptions options_;
  TexelSamples texel_;
};

Equations gather(const UnlightWork& work, const Columns& columns, const std::vector<std::int64_t>& texels,
                 const RunControl& control) {
  const Equations zero{
      Eigen::MatrixXd::Zero(columns.size(), columns.size()), Eigen::VectorXd::Zero(columns.size()), {}};
  const auto map = [&](std::int64_t begin, std::int64_t end) {
    Equations sums = zero;
    TexelEquations equations(work, columns);
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t at = texels[i];
      equations.add(static_cast<int>(at % work.width), static_cast<int>(at / work.width), sums);
    }
    return sums;
  };
  return parallel_reduce(static_cast<std::int64_t>(texels.size()), kLampTexelsAChunk, control, zero, map,
                         [](Equations a, const Equations& b) {
                           a.matrix += b.matrix;
                           a.right += b.right;
                           a.chi2.insert(a.chi2.end(), b.chi2.begin(), b.chi2.end());
                           return a;
                         });
}

/// Fixes the sum of the logarithms in each channel, which nothing else does.
void add_gauge(const UnlightWork& work, const Columns& columns, Eigen::MatrixXd& matrix) {
  if (!work.options.estimate_strengths) return;
  const double weight = matrix.diagonal().maxCoeff();
  for (int c = 0; c < work.num_channels; ++c) {
    for (int j = 0; j < work.num_lights; ++j) {
      for (int k = 0; k < work.num_lights; ++k)
        matrix(columns.strength(j, c), columns.strength(k, c)) += weight / work.num_lights;
    }
  }
}

/// Strengths of lamps that no clean sample shows stay.
void hold_unseen(Eigen::MatrixXd& matrix) {
  const double weight = matrix.diagonal().maxCoeff();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    if (!(matrix(i, i) > 1e-12 * weight)) matrix(i, i) += std::max(weight, 1.0);
  }
}

bool is_singular(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd scale = matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  constexpr double kLeast = 1e-7;  // Relative eigenvalue, below which strengths are not determined.
  return !(symmetric_eigenvalues(scaled).minCoeff() > kLeast);
}

/// @returns how far it went, in shares of a strength or of the mean light.
double apply(UnlightWork& work, const Columns& columns, const Eigen::VectorXd& step, double mean_light) {
  constexpr double kMaxStep = 0.7;  // Step of a logarithm: a strength at most doubles.
  double change = 0.0;
  for (int c = 0; c < work.num_channels; ++c) {
    for (int k = 0; k < work.num_lights && columns.strength(k, c) >= 0; ++k) {
      const double d = std::clamp(step[columns.strength(k, c)], -kMaxStep, kMaxStep);
      work.strengths[k][c] *= std::exp(d);
      change = std::max(change, std::abs(d));
    }
    if (columns.ambient(c) < 0) continue;
    const double d = std::clamp(step[columns.ambient(c)], -mean_light, mean_light);
    work.ambient[c] += d;
    change = std::max(change, std::abs(d) / mean_light);
  }
  if (work.num_channels == 1) {
    work.ambient = Vec3::Constant(work.ambient[0]);
    for (Vec3& s : work.strengths) s = Vec3::Constant(s[0]);
  }
  return change;
}

/// Mean of the lamps' irradiance at the texels.
double mean_irradiance(const UnlightWork& work, const std::vector<std::int64_t>& texels) {
  double sum = 0.0;
  TexelSamples texel;
  for (std::int64_t at : texels) {
    work.load(static_cast<int>(at % work.width), static_cast<int>(at / work.width), texel);
    for (double v : texel.irradiance) sum += v * std::numbers::pi / static_cast<double>(texel.irradiance.size());
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, texels.size()));
}

}  // namespace

LampEstimate estimate_lamps(UnlightWork& work, const RunControl& control) {
  constexpr int kMaxSteps = 60;  // It ends earlier where strengths rest.
  // The noise at most halves in a step, so that outliers are not kept too early.
  constexpr double kMaxShrink = 2.0;
  constexpr double kSmallStep = 1e-6;  // Step of a logarithm.
  const Columns columns(work);
  LampEstimate result;
  if (columns.size() == 0) return {.is_converged = true};
  const std::vector<std::int64_t> texels = work.spread_texels(kMaxLampTexels);
  const double mean_light = mean_irradiance(work, texels);
  // Wide to begin with, and narrower by steps: a lamp that is off must not be taken for a shadow or a highlight.
  work.noise_scale = estimate_noise_scale(work, control.part(0.0, 0.1), 1);
  const RunControl silent = control.silent();
  for (; result.num_steps < kMaxSteps && !result.is_converged; ++result.num_steps) {
    Equations equations = gather(work, columns, texels, silent);
    if (equations.chi2.empty()) return result;
    add_gauge(work, columns, equations.matrix);
    hold_unseen(equations.matrix);
    result.is_determined = !is_singular(equations.matrix);
    const Eigen::VectorXd step = solve_ldlt(equations.matrix, equations.right);
    if (!step.allFinite()) return result;
    result.is_converged = apply(work, columns, step, mean_light) < kSmallStep;
    const double middle = median(std::move(equations.chi2));
    control.report(0.1 + 0.9 * (result.num_steps + 1) / (kMaxSteps + 1));
    work.noise_scale = std::max({kMinScale, work.noise_scale / kMaxShrink, work.noise_scale * std::sqrt(middle)});
  }
  control.report(1.0);
  return result;
}

}  // namespace patinate::capture
