/// \file
/// Rust-colored stains that are no rust: translucent streaks that run down from spots, with soft edges.
#pragma once

#include <vector>

#include "datasets_synthetic/panel_marks.h"
#include "patinate/core/run_control.h"
#include "patinate/datasets/panel.h"

namespace patinate::datasets {

/// One stain at the end. Places are in pixels from the picture's upper left corner.
struct Streak {
  double x_px = 0.0;
  double y_px = 0.0;
  double length_px = 0.0;
  double width_px = 0.0;
  double opacity = 0.0;  ///< Largest, (0, 1).
  double start_h = 0.0;
};

/// Streaks below some of the spots, the larger ones first, and anywhere else, that tint as much of the test area at the
/// end as was asked for.
[[nodiscard]] std::vector<Streak> make_streaks(const PanelOptions& o, const std::vector<SpotOutline>& spots,
                                               const RunControl& control);
/// Opacity of all streaks at a time, [0, 1). @param scale  Factor of lengths and widths.
[[nodiscard]] ImageF draw_streaks(const std::vector<Streak>& streaks, const PanelOptions& o, double hours, double scale,
                                  const RunControl& control);
/// Percent of the test area where the opacity is at least PanelFigures::kVisibleStain at a pixel's center.
[[nodiscard]] double stained_percent(const ImageF& stain, const SampleFrame& test_area);

}  // namespace patinate::datasets
