/// \file
/// Rust-colored stains that are no rust: translucent streaks that run down from spots, with soft edges.
#pragma once

#include <vector>

#include "datasets_synthetic/panel_marks.h"
#include "datasets_synthetic/smooth_noise.h"
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

/// All streaks. Immutable; safe to use from several threads.
class Stains {
 public:
  /// Streaks below some of the spots, the larger ones first, and anywhere else, that tint as much of the test area at
  /// the end as was asked for.
  Stains(const PanelOptions& o, const std::vector<SpotOutline>& spots, const SampleFrame& test_area,
         const RunControl& control);
  [[nodiscard]] bool empty() const { return streaks_.empty(); }
  /// Opacity at a time, [0, 1). @param scale  Factor of lengths and widths.
  [[nodiscard]] ImageF draw(double hours, double scale, const RunControl& control) const;

 private:
  const PanelOptions options_;
  SmoothNoise sway_, runs_;
  std::vector<Streak> streaks_;
};
/// Percent of the test area where the opacity is at least PanelFigures::kVisibleStain at a pixel's center.
[[nodiscard]] double stained_percent(const ImageF& stain, const SampleFrame& test_area);

}  // namespace patinate::datasets
