#include "capture/stability/static_light_fit.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/calibration/ceres_solve.h"
#include "libcommon/core/median.h"

namespace patinate::capture {

namespace {

constexpr double kMinLight = 1e-4;        ///< Light below it is black.
constexpr double kOutlier = 0.1;          ///< In logarithms: the surface's own patterns are more than that.
constexpr double kDerivativeStep = 1e-3;  ///< Step of the derivatives; medians are flat below it.
constexpr double kFaint = 0.05;           ///< Share of the mean light: where the reflection's strength starts.
constexpr int kMostIterations = 30;       ///< It ends earlier where the fit rests.
/// Numbers of the fit: place below the lamp, log of 1 / h^2; middle of the reflection, log of 1 / w^2, log of strength.
constexpr std::size_t kNumLamp = 3, kNumReflection = 4;
/// A lamp may stand beside the picture, 0.3 to 20 half sides above it; a reflection's middle is in it or close by, its
/// width a sixth (a window) to one and a half half sides.
constexpr std::array<double, kNumLamp> kLampLow{-2.5, -2.5, -6.0}, kLampHigh{2.5, 2.5, 2.5};
constexpr std::array<double, kNumReflection> kReflectionLow{-1.3, -1.3, -1.0, -12.0},
    kReflectionHigh{1.3, 1.3, 3.6, 1.0};

/// The color of each frame and channel, and what the windows' logarithms are off by.
class Residuals {
 public:
  Residuals(const WindowSeries& series, const FitParts& parts) : series_(series), parts_(parts) {}

  [[nodiscard]] LightFit unpack(const double* numbers) const {
    LightFit fit;
    if (parts_.lamp) {
      fit.lamp = {{numbers[0], numbers[1]}, std::exp(numbers[2])};
      numbers += kNumLamp;
    }
    if (parts_.reflection) fit.reflection = {{numbers[0], numbers[1]}, std::exp(numbers[2]), std::exp(numbers[3])};
    return fit;
  }

  /// One per window, frame and channel; 0 where nothing is known.
  [[nodiscard]] std::vector<double> of(const LightFit& fit) const {
    std::vector<double> lamp, reflection, result;
    double mean = 0.0;
    for (const PicturePoint& p : series_.places) {
      lamp.push_back(fit.lamp.at(p));
      reflection.push_back(fit.reflection.at(p));
      mean += lamp.back() / static_cast<double>(series_.places.size());
    }
    for (double& l : lamp) l /= mean;
    for (const std::vector<double>& values : series_.values) {
      std::vector<double> albedos;
      for (std::size_t k = 0; k < values.size(); ++k)
        if (!std::isnan(values[k])) albedos.push_back((values[k] - reflection[k]) / lamp[k]);
      const double albedo = std::max(median(std::move(albedos)), kMinLight);
      for (std::size_t k = 0; k < values.size(); ++k) {
        const double expected = std::max(lamp[k] * albedo + reflection[k], kMinLight);
        result.push_back(std::isnan(values[k]) ? 0.0 : std::log(std::max(values[k], kMinLight)) - std::log(expected));
      }
    }
    return result;
  }

  bool operator()(double const* const* numbers, double* residuals) const {
    const std::vector<double> off = of(unpack(numbers[0]));
    // Charbonnier's loss, residual by residual: Ceres has losses for whole blocks.
    std::transform(off.begin(), off.end(), residuals, [](double r) {
      const double size = std::sqrt(2.0 * (std::sqrt(1.0 + r * r / (kOutlier * kOutlier)) - 1.0));
      return kOutlier * (r < 0.0 ? -size : size);
    });
    return true;
  }

  [[nodiscard]] int count() const { return static_cast<int>(series_.values.size() * series_.places.size()); }

 private:
  const WindowSeries& series_;
  FitParts parts_;
};

/// Where a course over all frames and channels is largest, and the mean of all.
struct Start {
  PicturePoint brightest;      ///< By the mean.
  PicturePoint always_bright;  ///< By the smallest value.
  double mean = 0.0;
};

Start start_of(const WindowSeries& series) {
  Start start;
  double best_mean = -1.0, best_least = -1.0, num_all = 0.0;
  for (std::size_t k = 0; k < series.places.size(); ++k) {
    double sum = 0.0, num = 0.0, least = std::numeric_limits<double>::max();
    for (const std::vector<double>& values : series.values) {
      if (std::isnan(values[k])) continue;
      sum += values[k];
      num += 1.0;
      least = std::min(least, values[k]);
    }
    if (!(num > 0.0)) continue;
    start.mean += sum;
    num_all += num;
    if (sum / num > best_mean) best_mean = sum / num, start.brightest = series.places[k];
    if (least > best_least) best_least = least, start.always_bright = series.places[k];
  }
  start.mean /= std::max(1.0, num_all);
  return start;
}

struct Solution {
  LightFit fit;
  double cost = std::numeric_limits<double>::max();
};

Solution solve_from(std::vector<double> numbers, const WindowSeries& series, const FitParts& parts) {
  ceres::NumericDiffOptions steps;
  steps.relative_step_size = kDerivativeStep;
  // Ceres owns functor and cost.
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Residuals, ceres::FORWARD>(new Residuals(series, parts),
                                                                                    ceres::TAKE_OWNERSHIP, steps);
  cost->AddParameterBlock(static_cast<int>(numbers.size()));
  const Residuals residuals(series, parts);
  cost->SetNumResiduals(residuals.count());
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, numbers.data());
  std::vector<double> low, high;
  if (parts.lamp) {
    low.insert(low.end(), kLampLow.begin(), kLampLow.end());
    high.insert(high.end(), kLampHigh.begin(), kLampHigh.end());
  }
  if (parts.reflection) {
    low.insert(low.end(), kReflectionLow.begin(), kReflectionLow.end());
    high.insert(high.end(), kReflectionHigh.begin(), kReflectionHigh.end());
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = std::clamp(numbers[i], low[i] + kDerivativeStep, high[i] - kDerivativeStep);
    problem.SetParameterLowerBound(numbers.data(), static_cast<int>(i), low[i]);
    problem.SetParameterUpperBound(numbers.data(), static_cast<int>(i), high[i]);
  }
  solve_quietly(problem, kMostIterations);
  Solution solution{residuals.unpack(numbers.data())};
  problem.Evaluate({}, &solution.cost, nullptr, nullptr, nullptr);
  return solution;
}

}  // namespace

LightFit fit_light(const WindowSeries& series, const FitParts& parts) {
  Solution best;
  if (parts.lamp || parts.reflection) {
    const Start start = start_of(series);
    for (double height : parts.lamp ? std::vector<double>{-1.0, 1.0} : std::vector<double>{0.0}) {
      for (double width : parts.reflection ? std::vector<double>{0.5, 2.5} : std::vector<double>{0.0}) {
        std::vector<double> numbers;
        if (parts.lamp) numbers = {start.brightest.x, start.brightest.y, height};
        if (parts.reflection) {
          const double strength = std::log(std::max(kFaint * start.mean, kMinLight));
          numbers.insert(numbers.end(), {start.always_bright.x, start.always_bright.y, width, strength});
        }
        const Solution found = solve_from(std::move(numbers), series, parts);
        if (found.cost < best.cost) best = found;
      }
    }
  }
  double sum = 0.0, num = 0.0;
  for (double r : Residuals(series, parts).of(best.fit)) {
    sum += r * r;
    num += r != 0.0 ? 1.0 : 0.0;
  }
  best.fit.variance = sum / std::max(1.0, num);
  return best.fit;
}

}  // namespace patinate::capture
