#include "capture/chart/chart_problem.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "capture/calibration/ceres_solve.h"
#include "capture/chart/unclamped_lab.h"

namespace patinate::capture {

namespace {

// Priors, in the same units as a difference of one CIEDE2000: weaker than one patch of one photograph.
constexpr Color3 kBendDeviations{0.5, 0.1, 0.03};
constexpr double kMixDeviation = 0.3;         ///< See docs/algorithms/chart.md, The model.
constexpr double kSlopeDeviation = 0.5;       ///< Slope of the light that all photographs share.
constexpr double kOwnSlopeDeviation = 0.05;   ///< Slope of each: the chart is tilted a little.
constexpr double kVignettingDeviation = 0.5;  ///< See docs/algorithms/chart.md, The model.
constexpr double kGaugeDeviation =
    1e-3;                           ///< Deviation of the first photograph's gains, which the matrix could have as well.
constexpr double kMisfit = 1.0;     ///< CIEDE2000 that a 3 x 3 matrix leaves of most patches.
constexpr double kNoise = 0.2;      ///< CIEDE2000 by which a patch differs from one photograph to another.
constexpr double kLossScale = 3.0;  ///< Deviations of either from which on a patch counts less.
/// Share of the largest value: what is darker has no logarithm worth fitting. The black patch has 0.03 of the light,
/// and under 0.001 where linear codes were taken for sRGB.
constexpr double kMinShare = 1e-3;
constexpr int kMostIterations = 100;  ///< It ends earlier where the fit rests.
constexpr double kDarkest = 1e-9;     ///< In place of a channel that is black all over.

template <class T>
std::array<T, 3> color_of(const std::array<T, 3>& light, const T* mix, const T* color, const T* field,
                          const T* of_photo, const ChartSample& at) {
  const std::array<T, 3> sensor{light[0] + mix[0] * light[1] + mix[1] * light[2],
                                mix[2] * light[0] + light[1] + mix[3] * light[2],
                                mix[4] * light[0] + mix[5] * light[1] + light[2]};
  using std::exp;
  const T even = field[0] * at.r2 - (field[1] + of_photo[3]) * at.dx - (field[2] + of_photo[4]) * at.dy;
  std::array<T, 3> gained;
  for (int c = 0; c < 3; ++c) gained[c] = sensor[c] * exp(of_photo[c] + even);
  std::array<T, 3> out;
  for (int i = 0; i < 3; ++i)
    out[i] = color[3 * i] * gained[0] + color[3 * i + 1] * gained[1] + color[3 * i + 2] * gained[2];
  return out;
}

struct PatchCost {
  ChartSample sample;
  Color3 u{}, middle{};  ///< Logarithms of the values over the middle ones.
  Color3 share{};        ///< Share of the light at the response's lower end: 1, or less for values below it.

  template <class T>
  bool operator()(const T* bend, const T* mix, const T* color, const T* field, const T* misfit, const T* of_photo,
                  T* residual) const {
    using std::exp;
    std::array<T, 3> light;
    for (int c = 0; c < 3; ++c) {
      const T* p = bend + 3 * c;
      light[c] = share[c] * middle[c] * exp(u[c] * (1.0 + p[0] + u[c] * (p[1] + u[c] * p[2])));
    }
    const std::array<T, 3> lab = unclamped_lab(color_of(light, mix, color, field, of_photo, sample));
    const T da = lab[1] - sample.truth_lab[1], db = lab[2] - sample.truth_lab[2];
    const double chroma = std::hypot(sample.truth_lab[1], sample.truth_lab[2]);
    const double ca = chroma > 0.0 ? sample.truth_lab[1] / chroma : 1.0;
    const double cb = chroma > 0.0 ? sample.truth_lab[2] / chroma : 0.0;
    residual[0] = lab[0] - sample.truth_lab[0];
    residual[1] = (ca * da + cb * db) / (1.0 + 0.045 * chroma);
    residual[2] = (ca * db - cb * da) / (1.0 + 0.015 * chroma);
    for (int k = 0; k < 3; ++k) residual[k] = (residual[k] - misfit[k]) / kNoise;
    return true;
  }
};

/// Keeps numbers near 0, each by its own deviation.
struct PriorCost {
  std::vector<double> deviations;

  template <class T>
  bool operator()(T const* const* numbers, T* residuals) const {
    for (std::size_t i = 0; i < deviations.size(); ++i) residuals[i] = numbers[0][i] / deviations[i];
    return true;
  }
};

void add_prior(ceres::Problem& problem, double* numbers, const std::vector<double>& deviations,
               ceres::LossFunction* loss = nullptr) {
  auto* cost = new ceres::DynamicAutoDiffCostFunction<PriorCost>(new PriorCost{deviations});  // Ceres owns both.
  cost->AddParameterBlock(static_cast<int>(deviations.size()));
  cost->SetNumResiduals(static_cast<int>(deviations.size()));
  problem.AddResidualBlock(cost, loss, numbers);
}

std::vector<double> bend_deviations() {
  std::vector<double> all;
  for (int c = 0; c < 3; ++c) all.insert(all.end(), kBendDeviations.begin(), kBendDeviations.end());
  return all;
}

double log_of(double value, const ChannelResponse& response) { return std::log(std::max(value, response.low)); }

PatchCost cost_of(const ChartSample& sample, const std::array<ChannelResponse, 3>& responses) {
  PatchCost cost{.sample = sample};
  for (std::size_t c = 0; c < 3; ++c) {
    cost.middle[c] = responses[c].middle;
    cost.u[c] = log_of(sample.value[c], responses[c]) - std::log(responses[c].middle);
    cost.share[c] = std::min(1.0, sample.value[c] / responses[c].low);
  }
  return cost;
}

}  // namespace

ChartProblem::ChartProblem(const std::vector<ChartSight>& sights, const ChartTable& table) : table_(table) {
  for (const ChartSight& sight : sights) add_sight(sight);
  set_responses();
}

void ChartProblem::add_sight(const ChartSight& sight) {
  std::vector<ChartSample> samples;
  double x = 0.0, y = 0.0, r2 = 0.0;
  const double count = static_cast<double>(sight.patches.size());
  for (const PatchLight& patch : sight.patches) {
    x += patch.x / count;
    y += patch.y / count;
    r2 += (patch.x * patch.x + patch.y * patch.y) / count;
  }
  for (std::size_t i = 0; i < sight.patches.size(); ++i) {
    const PatchLight& patch = sight.patches[i];
    samples.push_back({.value = patch.light,
                       .truth_lab = table_[i].lab,
                       .dx = patch.x - x,
                       .dy = patch.y - y,
                       .is_used = !patch.is_clipped,
                       .r2 = patch.x * patch.x + patch.y * patch.y - r2});
  }
  samples_.push_back(std::move(samples));
  radius2_.push_back(r2);
}

void ChartProblem::set_responses() {
  for (std::size_t c = 0; c < 3; ++c) {
    ChannelResponse& response = responses_[c];
    response.high = kDarkest;
    for (const std::vector<ChartSample>& samples : samples_) {
      for (const ChartSample& sample : samples) response.high = std::max(response.high, sample.value[c]);
    }
    response.low = response.high;
    double sum = 0.0, count = 0.0;
    for (const std::vector<ChartSample>& samples : samples_) {
      for (const ChartSample& sample : samples) {
        if (!sample.is_used) continue;
        const double value = std::max(sample.value[c], kMinShare * response.high);
        response.low = std::min(response.low, value);
        sum += std::log(value);
        count += 1.0;
      }
    }
    response.middle = std::exp(sum / count);
  }
}

ChartUnknowns ChartProblem::start(const std::vector<std::size_t>& photos) const {
  ChartUnknowns unknowns{.misfits = std::vector<Color3>(table_.size())};
  const std::vector<ChartSample>& first = samples_[photos[0]];
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), right = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (!first[i].is_used) continue;
    const Eigen::Vector3d value(first[i].value.data()), truth(table_[i].linear.data());
    const double weight = 1.0 / std::pow(std::max(0.0, truth.mean()) + kChartFloor, 2.0);
    normal += weight * value * value.transpose();
    right += weight * value * truth.transpose();
  }
  normal.diagonal().array() += 1e-9 * normal.trace();
  const Eigen::Matrix3d matrix = normal.ldlt().solve(right).transpose();
  for (int i = 0; i < 9; ++i) unknowns.color[static_cast<std::size_t>(i)] = matrix(i / 3, i % 3);
  for (const std::size_t photo : photos) {
    std::array<double, 5> light{};
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < first.size(); ++i) {
        if (!first[i].is_used || !samples_[photo][i].is_used) continue;
        light[c] += (log_of(first[i].value[c], responses_[c]) - log_of(samples_[photo][i].value[c], responses_[c])) /
                    static_cast<double>(first.size());
      }
    }
    unknowns.lights.push_back(light);
  }
  return unknowns;
}

ChartSolution ChartProblem::solve(const std::vector<std::size_t>& photos, ChartUnknowns unknowns, bool has_vignetting,
                                  bool asks_deviation) const {
  ceres::Problem problem;
  add_prior(problem, unknowns.bend.data(), bend_deviations());
  add_prior(problem, unknowns.mix.data(), std::vector<double>(6, kMixDeviation));
  constexpr double kNone = 1e-9;  // Standard deviation that holds a parameter at its prior.
  add_prior(problem, unknowns.field.data(),
            {has_vignetting ? kVignettingDeviation : kNone, kSlopeDeviation, kSlopeDeviation});
  std::vector<double*> of_photos;
  for (std::size_t k = 0; k < photos.size(); ++k) {
    double* light = unknowns.lights[k].data();
    of_photos.push_back(light);
    for (std::size_t i = 0; i < table_.size(); ++i) {
      const ChartSample& sample = samples_[photos[k]][i];
      if (!sample.is_used) continue;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PatchCost, 3, 9, 6, 9, 3, 3, 5>(new PatchCost(cost_of(sample, responses_))),
          new ceres::CauchyLoss(kLossScale), unknowns.bend.data(), unknowns.mix.data(), unknowns.color.data(),
          unknowns.field.data(), unknowns.misfits[i].data(), light);
    }
    constexpr double kFree = 100.0;  // Standard deviation that leaves a parameter free, logarithm.
    const double gain = k == 0 ? kGaugeDeviation : kFree;
    add_prior(problem, light, {gain, gain, gain, kOwnSlopeDeviation, kOwnSlopeDeviation});
  }
  for (Color3& misfit : unknowns.misfits)
    add_prior(problem, misfit.data(), std::vector<double>(3, kMisfit), new ceres::CauchyLoss(kLossScale));
  ChartSolution solution;
  solution.has_converged = solve_quietly(problem, kMostIterations, of_photos).has_converged;
  solution.vignetting_deviation = std::numeric_limits<double>::infinity();
  if (asks_deviation && has_vignetting) {
    std::vector<double*> blocks{unknowns.field.data(), unknowns.bend.data(), unknowns.mix.data(),
                                unknowns.color.data()};
    for (Color3& misfit : unknowns.misfits) blocks.push_back(misfit.data());
    blocks.insert(blocks.end(), of_photos.begin(), of_photos.end());
    const Information info = information_of(problem, blocks);
    if (info.is_determined) solution.vignetting_deviation = std::sqrt(info.covariance(0, 0));
  }
  solution.unknowns = std::move(unknowns);
  return solution;
}

std::array<ChannelResponse, 3> ChartProblem::responses(const ChartUnknowns& unknowns) const {
  std::array<ChannelResponse, 3> responses = responses_;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 3; ++k) responses[c].bend[k] = unknowns.bend[3 * c + k];
  }
  return responses;
}
}  // namespace patinate::capture
