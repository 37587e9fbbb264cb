/// \file
/// Fits a color chart in photographs to the true colors of its patches: one camera response for the series, and the
/// light of each photograph.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "capture/chart/chart_table.h"
#include "capture/chart/measure_chart.h"
#include "patinate/image/image.h"

namespace patinate::capture {

using Color3 = std::array<double, 3>;
using Matrix3 = std::array<Color3, 3>;  ///< Row by row.

/// Response of one channel: the light L that a photograph's linear value v stands for, relative to `middle`.
///
/// log L = log middle + u (1 + p0) + p1 u^2 + p2 u^3 with u = log(v / middle): p = 0 where the photograph is linear
/// light already, p0 for another gamma, p1 and p2 for a tone curve. Outside of [low, high] it goes on as a line through
/// 0 below, and with the slope of its end in logarithms above.
struct ChannelResponse {
  double middle = 0.2;
  double low = 0.0, high = 1.0;  ///< Values that the chart shows.
  Color3 bend{};                 ///< p.

  [[nodiscard]] double light(double value) const;
  /// Least slope of log L over log v between low and high; > 0 where codes tell the light.
  [[nodiscard]] double least_slope() const;
};

/// Parameters that all photographs of a series share.
struct ChartCamera {
  std::array<ChannelResponse, 3> response = {};
  /// Sensor from photograph: its gains are those of white balance; 1 on the diagonal.
  Matrix3 sensor{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Matrix3 color{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< Linear Rec. 709 from the sensor in the first light.
  std::optional<double> vignetting =
      {};  ///< a of exp(-a r^2), r in half diagonals; nothing where the chart cannot tell.
};

/// Light of one photograph.
struct ChartLight {
  Color3 gain{1.0, 1.0, 1.0};           ///< Gain of the sensor's channels; those of the first photograph are 1.
  double slope_x = 0.0, slope_y = 0.0;  ///< Slopes of the logarithm of light over the chart, by half diagonals.
  double radius2 = 0.0;                 ///< Mean squared distance of the chart from the middle, in half diagonals.
};

/// How well one photograph's chart fits.
struct ChartResidual {
  double mean = 0.0;  ///< CIEDE2000 over the patches.
  double worst = 0.0;
  std::size_t worst_patch = 0;
  std::vector<double> patches;  ///< CIEDE2000 of each; 0 of those that are clipped.
};

enum class ChartFitStatus {
  Converged,
  IterationLimit,
  NoResponse,  ///< Codes do not rise with light over the gray patches: nothing can be said of color.
};

struct ChartFit {
  ChartFitStatus status = ChartFitStatus::Converged;
  ChartCamera camera;
  std::vector<ChartLight> lights;        ///< Light of each sight.
  std::vector<ChartResidual> residuals;  ///< Likewise.
  /// Root mean square over all patches of (color - truth) / (truth + kChartFloor), by channel of linear Rec. 709;
  /// raised to what it is for colors that took no part in the fit.
  Color3 deviation{};
};
/// Linear light to which deviations are relative where a color is dark: that of the black patch.
inline constexpr double kChartFloor = 0.03;

/// Weighted differences in CIELAB (chroma and hue as CIE94 weighs them) of all patches in all photographs, with
/// Cauchy's loss: a patch with a spot does not turn the others. Response, sensor and matrix are those of the series;
/// each photograph has its three gains and a slope of its light over the chart, nearly that of the others. Weak priors
/// keep what a chart does not show where it is without: response linear, sensor = photograph, no slope. Vignetting is
/// kept where it is larger than twice its standard deviation and that is below a twentieth.
/// @param sights  One or more, without problems. @throws InvalidInput if there are none.
[[nodiscard]] ChartFit fit_chart(const std::vector<ChartSight>& sights, const ChartTable& table);

/// Linear Rec. 709, D65, of a photograph's value at a place. @param x,y  In half diagonals from its middle.
[[nodiscard]] Color3 chart_color(const ChartCamera& camera, const ChartLight& light, const Color3& value, double x,
                                 double y);
/// Applies the chart to a whole photograph. Negative values, of colors that Rec. 709 does not have, become 0.
/// @param photo  H x W x 3, linear as it was measured. @returns Pixels of which a channel was below -0.001.
std::int64_t apply_chart(const ChartCamera& camera, const ChartLight& light, ImageF& photo);

}  // namespace patinate::capture
