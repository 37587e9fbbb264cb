/// \file
/// The least squares behind fit_chart(). Inside of the chart only.
#pragma once

#include <array>
#include <vector>

#include "capture/chart/chart_fit.h"

namespace patinate::capture {

/// One patch of one photograph.
struct ChartSample {
  Color3 value{}, truth_lab{};
  double dx = 0.0, dy = 0.0;  ///< From the middle of the chart, in half diagonals.
  bool is_used = true;        ///< Not clipped.
  double r2 = 0.0;            ///< Squared distance from the photograph's middle, less the chart's mean.
};

/// Numbers that are solved for.
struct ChartUnknowns {
  std::array<double, 9> bend{};      ///< p of red, green, blue.
  std::array<double, 6> mix{};       ///< The sensor's matrix without its diagonal, row by row.
  std::array<double, 9> color{};     ///< Row by row.
  Color3 field{};                    ///< Vignetting, and the slope of the light in x and y that all photographs share.
  std::vector<Color3> misfits = {};  ///< Misfits of each patch, in all photographs: what the matrix leaves of it.
  std::vector<std::array<double, 5>> lights = {};  ///< Logarithms of gains, and what the slope has more.
};

struct ChartSolution {
  ChartUnknowns unknowns;
  bool has_converged = false;
  double vignetting_deviation = 0.0;  ///< Standard deviation; infinite where it is not determined or not asked for.
};

/// Residuals of the patches in all photographs.
class ChartProblem {
 public:
  /// @param table  Must outlive this.
  ChartProblem(const std::vector<ChartSight>& sights, const ChartTable& table);

  /// Photographs as linear light, colors by a matrix: what is solved from. @param photos  That take part.
  [[nodiscard]] ChartUnknowns start(const std::vector<std::size_t>& photos) const;
  /// @param has_vignetting  Else it is 0. @param asks_deviation  Costs the square of the photographs.
  [[nodiscard]] ChartSolution solve(const std::vector<std::size_t>& photos, ChartUnknowns start, bool has_vignetting,
                                    bool asks_deviation) const;
  [[nodiscard]] std::array<ChannelResponse, 3> responses(const ChartUnknowns& unknowns) const;
  /// ChartLight::radius2.
  [[nodiscard]] double radius2(std::size_t photo) const { return radius2_[photo]; }

 private:
  void add_sight(const ChartSight& sight);
  void set_responses();

  const ChartTable& table_;
  std::vector<std::vector<ChartSample>> samples_;
  std::vector<double> radius2_;
  std::array<ChannelResponse, 3> responses_;
};

}  // namespace patinate::capture
