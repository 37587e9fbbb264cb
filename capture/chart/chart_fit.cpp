#include "capture/chart/chart_fit.h"

#include <algorithm>
#include <cmath>

#include "capture/chart/chart_problem.h"
#include "capture/chart/unclamped_lab.h"
#include "libcommon/image/color_matrix.h"
#include "patinate/core/error.h"
#include "patinate/metrics/difference.h"

namespace patinate::capture {

namespace {

constexpr double kMinSlope = 0.1;  ///< Slope of a response: from black to white it then spans the tenth of its range.
/// Numbers of a camera and one photograph: matrix, sensor, response, light. Of what a table says, the fit takes so many
/// to itself, and errs elsewhere by as much more.
constexpr double kNumFitted = 29.0;
constexpr std::size_t kMaxForVignetting = 12;
constexpr double kSureVignetting = 0.05;  ///< Standard deviation of light in the corners.

/// Photographs of all, evenly spread.
std::vector<std::size_t> spread(std::size_t count, std::size_t most) {
  std::vector<std::size_t> chosen;
  const std::size_t num = std::min(count, most);
  for (std::size_t k = 0; k < num; ++k) chosen.push_back(num == 1 ? 0 : k * (count - 1) / (num - 1));
  return chosen;
}

ChartCamera camera_of(const ChartProblem& problem, const ChartUnknowns& unknowns, bool has_vignetting) {
  ChartCamera camera{.response = problem.responses(unknowns)};
  std::size_t next = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (i != k) camera.sensor[i][k] = unknowns.mix[next++];
      camera.color[i][k] = unknowns.color[3 * i + k];
    }
  }
  if (has_vignetting) camera.vignetting = unknowns.field[0];
  return camera;
}

/// Color of light that has its response undone. @param even  Factor of the place.
Color3 color_of_light(const ChartCamera& camera, const ChartLight& of_photo, const Color3& light, double even) {
  Color3 sensor = product(camera.sensor, light);
  for (std::size_t c = 0; c < 3; ++c) sensor[c] *= of_photo.gain[c] * even;
  return product(camera.color, sensor);
}

double evening(const ChartCamera& camera, const ChartLight& light, double x, double y) {
  return camera.vignetting ? std::exp(*camera.vignetting * (x * x + y * y - light.radius2)) : 1.0;
}

/// Colors of a photograph's patches, without the slope of its light.
std::vector<Color3> patch_colors(const ChartFit& fit, std::size_t photo, const ChartSight& sight) {
  const ChartLight& light = fit.lights[photo];
  double x = 0.0, y = 0.0;
  for (const PatchLight& patch : sight.patches) {
    x += patch.x / static_cast<double>(sight.patches.size());
    y += patch.y / static_cast<double>(sight.patches.size());
  }
  std::vector<Color3> colors;
  for (const PatchLight& patch : sight.patches) {
    Color3 color = chart_color(fit.camera, light, patch.light, patch.x, patch.y);
    const double slope = std::exp(-light.slope_x * (patch.x - x) - light.slope_y * (patch.y - y));
    for (double& v : color) v *= slope;
    colors.push_back(color);
  }
  return colors;
}

void add_residuals(const std::vector<ChartSight>& sights, const ChartTable& table, ChartFit& fit) {
  double count = 0.0;
  for (std::size_t photo = 0; photo < sights.size(); ++photo) {
    const std::vector<Color3> colors = patch_colors(fit, photo, sights[photo]);
    ChartResidual residual{.patches = std::vector<double>(colors.size())};
    double num_used = 0.0;
    for (std::size_t i = 0; i < colors.size(); ++i) {
      if (sights[photo].patches[i].is_clipped) continue;
      const double error = ciede2000(unclamped_lab(colors[i]), table[i].lab);
      residual.patches[i] = error;
      residual.mean += error;
      num_used += 1.0;
      if (error > residual.worst) residual.worst = error, residual.worst_patch = i;
      for (std::size_t c = 0; c < 3; ++c) {
        const double truth = std::max(0.0, table[i].linear[c]);
        const double relative = (std::max(0.0, colors[i][c]) - truth) / (truth + kChartFloor);
        fit.deviation[c] += relative * relative;
      }
      count += 1.0;
    }
    residual.mean /= std::max(1.0, num_used);
    fit.residuals.push_back(std::move(residual));
  }
  const double num_said = 3.0 * static_cast<double>(table.size());
  const double less_than_taken = std::sqrt((num_said + kNumFitted) / (num_said - kNumFitted));
  for (double& v : fit.deviation) v = less_than_taken * std::sqrt(v / std::max(1.0, count));
}

}  // namespace

double ChannelResponse::light(double value) const {
  const auto within = [&](double v) {
    const double u = std::log(v / middle);
    return middle * std::exp(u * (1.0 + bend[0] + u * (bend[1] + u * bend[2])));
  };
  if (value < low) return value / low * within(low);
  if (value <= high) return within(value);
  const double u = std::log(high / middle);
  const double slope = 1.0 + bend[0] + u * (2.0 * bend[1] + 3.0 * u * bend[2]);
  return within(high) * std::pow(value / high, slope);
}

double ChannelResponse::least_slope() const {
  const auto slope = [&](double u) { return 1.0 + bend[0] + u * (2.0 * bend[1] + 3.0 * u * bend[2]); };
  const double from = std::log(low / middle), to = std::log(high / middle);
  double least = std::min(slope(from), slope(to));
  if (bend[2] > 0.0) least = std::min(least, slope(std::clamp(-bend[1] / (3.0 * bend[2]), from, to)));
  return least;
}

ChartFit fit_chart(const std::vector<ChartSight>& sights, const ChartTable& table) {
  if (sights.empty()) throw InvalidInput("fit_chart: a photograph of the chart is needed");
  const ChartProblem problem(sights, table);
  ChartFit fit;
  const std::vector<std::size_t> some = spread(sights.size(), kMaxForVignetting);
  const ChartSolution tried = problem.solve(some, problem.start(some), true, true);
  const double deviation = tried.vignetting_deviation, vignetting = tried.unknowns.field[0];
  const bool has_vignetting = deviation < kSureVignetting && vignetting > 2.0 * deviation;
  const std::vector<std::size_t> all = spread(sights.size(), sights.size());
  ChartUnknowns start = problem.start(all);
  start.bend = tried.unknowns.bend;
  start.mix = tried.unknowns.mix;
  start.color = tried.unknowns.color;
  start.misfits = tried.unknowns.misfits;
  start.field = tried.unknowns.field;
  if (!has_vignetting) start.field[0] = 0.0;
  const ChartSolution solution = problem.solve(all, start, has_vignetting, false);
  const ChartUnknowns& solved = solution.unknowns;
  fit.status = solution.has_converged ? ChartFitStatus::Converged : ChartFitStatus::IterationLimit;
  fit.camera = camera_of(problem, solved, has_vignetting);
  for (std::size_t i = 0; i < sights.size(); ++i) {
    ChartLight light{.slope_x = solved.field[1] + solved.lights[i][3],
                     .slope_y = solved.field[2] + solved.lights[i][4],
                     .radius2 = problem.radius2(i)};
    for (std::size_t c = 0; c < 3; ++c) light.gain[c] = std::exp(solved.lights[i][c]);
    fit.lights.push_back(light);
  }
  for (const ChannelResponse& response : fit.camera.response) {
    if (!(response.least_slope() > kMinSlope)) fit.status = ChartFitStatus::NoResponse;
  }
  add_residuals(sights, table, fit);
  return fit;
}

Color3 chart_color(const ChartCamera& camera, const ChartLight& light, const Color3& value, double x, double y) {
  Color3 lights{};
  for (std::size_t c = 0; c < 3; ++c) lights[c] = camera.response[c].light(value[c]);
  return color_of_light(camera, light, lights, evening(camera, light, x, y));
}

std::int64_t apply_chart(const ChartCamera& camera, const ChartLight& light, ImageF& photo) {
  constexpr double kRounding = 1e-3;  // Linear light below 0 that is rounding.
  const double half = 0.5 * std::hypot(photo.width(), photo.height());
  std::int64_t num_outside = 0;
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = 0; x < photo.width(); ++x) {
      const auto pixel = photo.pixel(x, y);
      Color3 value{};
      for (std::size_t c = 0; c < 3; ++c) value[c] = static_cast<double>(pixel[c]);
      const Color3 color = chart_color(camera, light, value, (x - 0.5 * (photo.width() - 1)) / half,
                                       (y - 0.5 * (photo.height() - 1)) / half);
      num_outside += *std::min_element(color.begin(), color.end()) < -kRounding ? 1 : 0;
      for (std::size_t c = 0; c < 3; ++c) pixel[c] = static_cast<float>(std::clamp(color[c], 0.0, 65504.0));
    }
  }
  return num_outside;
}

}  // namespace patinate::capture
