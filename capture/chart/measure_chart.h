/// \file
/// What a photograph shows of a chart's patches.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "capture/chart/chart_table.h"
#include "patinate/image/image.h"

namespace patinate::capture {

/// One patch in one photograph.
struct PatchLight {
  std::array<double, 3> light{};  ///< Mean linear light of its middle, without the tenths at both ends.
  double x = 0.0;                 ///< Where its middle lies, in half diagonals from the photograph's middle.
  double y = 0.0;
  double uneven = 0.0;      ///< Largest relative difference of a quarter of it from the whole.
  double saturated = 0.0;   ///< Share of its pixels.
  bool is_clipped = false;  ///< A channel is at an end of its codes: the camera does not hold its color.
  bool is_shown = false;    ///< It lies inside of the photograph.
};

/// The chart in one photograph; patches as the table has them.
struct ChartSight {
  std::vector<PatchLight> patches = {};
  std::string problem = "";  ///< Problem as ChartPlace has it; patches are then not to be used.
};

/// Meaning of a photograph's codes.
struct SensorView {
  const ImageF* photo = nullptr;  ///< Where saturation shows; as large as the linear photograph.
  float level = 0.0f;             ///< From which on a channel is saturated.
  bool has_codes = true;          ///< Integers: what is too dark is badly rounded.
};

/// Names as problems: patches outside of the photograph, patches of two colors (something lies over a part of them), a
/// brightest patch that is saturated, and one so dark that rounding of 8-bit codes shows in the black one.
/// @param linear  H x W x 3. @param photo_from_chart  As ChartPlace has it.
[[nodiscard]] ChartSight measure_chart(const ImageF& linear, const SensorView& sensor,
                                       const Eigen::Matrix3d& photo_from_chart, const ChartTable& table);

}  // namespace patinate::capture
