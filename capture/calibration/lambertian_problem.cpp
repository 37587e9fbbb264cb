#include "capture/calibration/lambertian_problem.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

namespace patinate::capture {

namespace {

constexpr double kLeastSigma = 1e-9;  ///< Exact values have no scale of their own.
constexpr int kShadeRounds = 3;

struct ShadeError {
  const ShadedSample* sample;
  double radius2;
  double scale2;

  template <class T>
  bool operator()(const T* position, const T* strength, const T* ambient, const T* vignetting, T* error) const {
    T to_light[3], d2(0.0), facing(0.0);
    for (int i = 0; i < 3; ++i) {
      to_light[i] = position[i] - T(sample->point_mm[i]);
      d2 += to_light[i] * to_light[i];
      facing += to_light[i] * T(sample->normal[i]);
    }
    if (!(d2 > T(0.0))) return false;
    const T lens = T(1.0) + T(radius2) * (vignetting[0] + T(radius2) * vignetting[1]);
    const T shade = facing > T(0.0) ? T(scale2) * facing / (d2 * sqrt(d2)) : T(0.0);
    for (int c = 0; c < 3; ++c) error[c] = strength[c] * shade * lens + ambient[c] - T(sample->value[c]);
    return true;
  }
};

}  // namespace

LambertianSolution refine_lambertian(const std::vector<std::vector<ShadedSample>>& samples,
                                     const std::vector<std::vector<double>>& radius2,
                                     const LambertianLightOptions& options, LambertianProblem& start) {
  LambertianSolution solution;
  double huber = 0.0;
  for (int round = 0; round <= kShadeRounds; ++round) {
    ceres::Problem problem;
    std::vector<std::vector<ceres::ResidualBlockId>> blocks(samples.size());
    for (std::size_t k = 0; k < samples.size(); ++k) {
      for (std::size_t i = 0; i < samples[k].size(); ++i) {
        auto* error = new ShadeError{&samples[k][i], radius2[k][i], start.scale_mm * start.scale_mm};
        blocks[k].push_back(problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ShadeError, 3, 3, 3, 3, 2>(error),
                                                     huber > 0 ? new ceres::HuberLoss(huber) : nullptr,
                                                     start.positions[k].data(), start.strengths[k].data(),
                                                     start.ambient.data(), start.vignetting.data()));
      }
    }
    if (!options.has_ambient) problem.SetParameterBlockConstant(start.ambient.data());
    if (!options.has_vignetting) problem.SetParameterBlockConstant(start.vignetting.data());
    solution.has_converged = solve_quietly(problem).has_converged;
    const std::vector<double> residuals = residuals_without_loss(problem);
    const double typical = std::max(kLeastSigma, robust_sigma(residuals));
    huber = options.huber_sigmas * typical;
    if (round < kShadeRounds) continue;
    std::vector<double*> parameters;
    for (std::size_t k = 0; k < samples.size(); ++k)
      parameters.push_back(start.positions[k].data()), parameters.push_back(start.strengths[k].data());
    if (options.has_ambient) parameters.push_back(start.ambient.data());
    if (options.has_vignetting) parameters.push_back(start.vignetting.data());
    solution.information = information_of(problem, parameters);
    double squares = 0.0;
    int num_near = 0;
    for (const double r : residuals) {
      if (std::abs(r) <= huber) squares += r * r, ++num_near;
    }
    solution.sigma = std::sqrt(squares / std::max(1, num_near - solution.information.num_parameters));
    std::size_t at = 0;
    for (const auto& of_light : samples) {
      double sum = 0.0;
      for (std::size_t i = 0; i < 3 * of_light.size(); ++i, ++at) sum += residuals[at] * residuals[at];
      solution.rms.push_back(std::sqrt(sum / (3.0 * static_cast<double>(of_light.size()))));
    }
  }
  return solution;
}

}  // namespace patinate::capture
