#include "patinate/capture/lambertian_lights.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "capture/calibration/ceres_solve.h"
#include "libcommon/core/parallel.h"
#include "patinate/core/error.h"

namespace patinate::capture {

namespace {

struct LambertianProblem {
  std::vector<Vec3> positions;
  std::vector<Vec3> strengths;  ///< albedo / pi * intensity / scale^2.
  Vec3 ambient = Vec3::Zero();
  Vec2 vignetting = Vec2::Zero();
  double scale_mm = 1.0;  ///< Brings strengths to the size of values.
};
struct LambertianSolution {
  bool has_converged = false;
  double sigma = 0.0;
  Information information;  ///< Position and strength of each light in turn, then ambient and vignetting where fitted.
  std::vector<double> rms;  ///< Rms of each light.
};

constexpr double kMinSigma = 1e-9;  ///< Exact values have no scale of their own.
constexpr int kShadeRounds = 3;     ///< Rounds with robust weights (docs/algorithms/light_calibration.md).

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

/// radius2[light][sample]: squared distance from the picture's middle, 1 at its corners. Refines `problem` in place.
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
    const double typical = std::max(kMinSigma, robust_sigma(residuals));
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

constexpr std::size_t kMinSamples = 20;  ///< Fewer samples do not determine position, strengths and vignetting.

/// Samples that tell something: not saturated, finite. @throws InvalidInput
std::vector<ShadedSample> usable(const std::vector<ShadedSample>& samples, std::size_t light,
                                 const LambertianLightOptions& options) {
  const std::string name = "light " + std::to_string(light + 1);
  std::vector<ShadedSample> used;
  double brightest = 0.0;
  for (const ShadedSample& s : samples) {
    if (!s.point_mm.allFinite() || !s.normal.allFinite() || !s.value.allFinite() || !s.pixel.allFinite())
      throw InvalidInput(name + ": a sample is not finite");
    if (!(std::abs(s.normal.norm() - 1.0) < 1e-3)) throw InvalidInput(name + ": a sample's normal is not of length 1");
    if (s.value.maxCoeff() >= options.saturated) continue;
    brightest = std::max(brightest, s.value.maxCoeff());
    used.push_back(s);
  }
  if (used.size() < kMinSamples) {
    const bool is_white = samples.size() >= kMinSamples;
    throw InvalidInput(name + (is_white ? ": nearly all samples are saturated; expected a shorter exposure"
                                        : ": too few samples of the object; expected at least 20"));
  }
  constexpr double kBlack = 1e-4;  // Linear value; a code of 8 bits is 3e-4 near black.
  if (!(brightest > kBlack)) throw InvalidInput(name + ": the photographs are black where the object is");
  return used;
}

/// Strengths (and ambient) that fit a light at `position` best, and the squares that are left.
struct LinearFit {
  Vec3 strength = Vec3::Zero();
  Vec3 ambient = Vec3::Zero();
  double squares = std::numeric_limits<double>::infinity();
};
LinearFit fit_at(const std::vector<ShadedSample>& samples, const Vec3& position, double scale_mm, bool has_ambient) {
  double aa = 0.0, a1 = 0.0;
  Vec3 av = Vec3::Zero(), v1 = Vec3::Zero();
  std::vector<double> shades;
  for (const ShadedSample& s : samples) {
    const Vec3 to_light = position - s.point_mm;
    const double shade =
        scale_mm * scale_mm * std::max(0.0, to_light.dot(s.normal)) / std::pow(to_light.squaredNorm(), 1.5);
    shades.push_back(shade);
    aa += shade * shade, a1 += shade, av += shade * s.value, v1 += s.value;
  }
  LinearFit fit;
  const double n = static_cast<double>(samples.size());
  const double det = has_ambient ? aa * n - a1 * a1 : aa;
  if (!(det > 1e-12 * aa * n) || !(aa > 0)) return fit;
  fit.strength = has_ambient ? Vec3((n * av - a1 * v1) / det) : Vec3(av / aa);
  if (has_ambient) fit.ambient = (aa * v1 - a1 * av) / det;
  if (!(fit.strength.minCoeff() > 0)) return fit;
  fit.squares = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    fit.squares += (shades[i] * fit.strength + fit.ambient - samples[i].value).squaredNorm();
  return fit;
}

struct Extent {
  Vec3 middle = Vec3::Zero();
  double radius = 0.0;
};
Extent extent_of(const std::vector<ShadedSample>& samples) {
  Extent extent;
  for (const ShadedSample& s : samples) extent.middle += s.point_mm / static_cast<double>(samples.size());
  for (const ShadedSample& s : samples) extent.radius = std::max(extent.radius, (s.point_mm - extent.middle).norm());
  return extent;
}

/// Best of a Fibonacci sphere of directions times a series of distances.
std::pair<Vec3, LinearFit> start_of_light(const std::vector<ShadedSample>& samples, const Extent& extent,
                                          double scale_mm, bool has_ambient, const RunControl& control) {
  // Starts of every light (docs/algorithms/light_calibration.md).
  constexpr int kDirections = 200, kDistances = 10;
  constexpr std::size_t kMaxSamples = 600;  // Samples that starts are judged by, evenly picked.
  std::vector<ShadedSample> some;
  const std::size_t step = std::max<std::size_t>(1, samples.size() / kMaxSamples);
  for (std::size_t i = 0; i < samples.size(); i += step) some.push_back(samples[i]);
  std::vector<std::pair<Vec3, LinearFit>> fits(kDirections * kDistances);
  parallel_for(kDirections * kDistances, 50, control, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t row = i / kDistances;
      const auto direction = static_cast<double>(row);
      const double z = 1.0 - 2.0 * (direction + 0.5) / kDirections, turn = 2.399963229728653 * direction;
      const double flat = std::sqrt(1.0 - z * z),
                   distance =
                       1.2 * extent.radius * std::pow(20.0, static_cast<double>(i % kDistances) / (kDistances - 1.0));
      const Vec3 position = extent.middle + distance * Vec3(flat * std::cos(turn), flat * std::sin(turn), z);
      fits[i] = {position, fit_at(some, position, scale_mm, has_ambient)};
    }
  });
  return *std::min_element(fits.begin(), fits.end(),
                           [](const auto& a, const auto& b) { return a.second.squares < b.second.squares; });
}

}  // namespace

void describe(OptionVisitor& v, LambertianLightOptions& o) {
  v.visit({"albedo", "of the object; strengths are in proportion to 1 / albedo", "", above(0)}, o.albedo);
  v.visit({"ambient", "fit light that is there without the lamps"}, o.has_ambient);
  v.visit({"vignetting", "fit the lens's darkening toward the corners"}, o.has_vignetting);
  v.visit({"saturated", "linear value from which on a pixel is excluded", "", above(0)}, o.saturated);
  v.visit({"huber_sigmas", "pixels farther off than so many standard deviations weigh less", "", above(0)},
          o.huber_sigmas);
  v.visit({"max_distance_sd", "a distance known worse than this share of it counts as not determined", "", above(0)},
          o.max_distance_sd);
}

LambertianLightResult lights_from_lambertian(const Camera& camera, const std::vector<std::vector<ShadedSample>>& given,
                                             const LambertianLightOptions& options, const RunControl& control) {
  check_ranges(options);
  if (given.empty()) throw InvalidInput("lights from a diffuse object need at least one light");
  std::vector<std::vector<ShadedSample>> samples;
  std::vector<Extent> extents;
  LambertianProblem problem;
  for (std::size_t k = 0; k < given.size(); ++k) {
    samples.push_back(usable(given[k], k, options));
    extents.push_back(extent_of(samples.back()));
    if (!(extents.back().radius > 0))
      throw InvalidInput("light " + std::to_string(k + 1) + ": all samples lie in one point");
    problem.scale_mm = std::max(problem.scale_mm, 4.0 * extents.back().radius);
  }
  for (std::size_t k = 0; k < given.size(); ++k) {
    const auto [position, fit] = start_of_light(samples[k], extents[k], problem.scale_mm, options.has_ambient, control);
    if (!std::isfinite(fit.squares))
      throw InvalidInput("light " + std::to_string(k + 1) + ": no place of a light explains the photographs");
    problem.positions.push_back(position);
    problem.strengths.push_back(fit.strength);
    problem.ambient += fit.ambient / static_cast<double>(given.size());
    // Surfaces that face away tell nothing; those in their own shadow would only pull.
    std::erase_if(samples[k], [&place = position](const ShadedSample& s) {
      return (place - s.point_mm).dot(s.normal) <= 0.05 * (place - s.point_mm).norm();
    });
    if (samples[k].size() < kMinSamples)
      throw InvalidInput("light " + std::to_string(k + 1) + " lies behind the object");
  }
  const CameraParameters& p = camera.parameters();
  std::vector<std::vector<double>> radius2;
  for (const auto& of_light : samples) {
    radius2.emplace_back();
    for (const ShadedSample& s : of_light) {
      radius2.back().push_back((s.pixel - Vec2(0.5 * (p.width - 1), 0.5 * (p.height - 1))).squaredNorm() /
                               Vec2(0.5 * p.width, 0.5 * p.height).squaredNorm());
    }
  }
  control.throw_if_stopped();
  const LambertianSolution solution = refine_lambertian(samples, radius2, options, problem);

  LambertianLightResult result;
  result.ambient = problem.ambient, result.vignetting = problem.vignetting, result.sigma = solution.sigma;
  const double strength_to_intensity = std::numbers::pi / options.albedo * problem.scale_mm * problem.scale_mm;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    LambertianLight light;
    light.light.kind = Light::Kind::Near;
    light.light.position = problem.positions[k];
    light.light.intensity = strength_to_intensity * problem.strengths[k];
    light.rms = solution.rms[k];
    light.num_samples = static_cast<int>(samples[k].size());
    light.distance_sd = std::numeric_limits<double>::infinity();
    const Vec3 to_light = light.light.position - extents[k].middle;
    if (solution.information.is_determined) {
      const auto at = static_cast<Eigen::Index>(6 * k);
      Eigen::Matrix<double, 6, 1> units;
      units << 1, 1, 1, strength_to_intensity, strength_to_intensity, strength_to_intensity;
      light.covariance = solution.sigma * solution.sigma * units.asDiagonal() *
                         solution.information.covariance.block<6, 6>(at, at) * units.asDiagonal();
      const Vec3 along = to_light.normalized();
      light.distance_sd =
          std::sqrt(std::max(0.0, along.dot(light.covariance.topLeftCorner<3, 3>() * along))) / to_light.norm();
    }
    const bool is_light = light.light.intensity.minCoeff() > 0 && light.light.position.allFinite();
    if (!is_light || !(light.distance_sd <= options.max_distance_sd)) {
      light.status = CalibrationStatus::Undetermined;
    } else {
      light.status = solution.has_converged ? CalibrationStatus::Converged : CalibrationStatus::IterationLimit;
    }
    result.lights.push_back(std::move(light));
  }
  return result;
}

}  // namespace patinate::capture
