/// \file
/// A coated panel one photograph at a time, for series that do not fit in memory.
#pragma once

#include <vector>

#include "datasets_synthetic/panel_layout.h"
#include "patinate/core/run_control.h"
#include "patinate/datasets/panel.h"

namespace patinate::datasets {

/// Makes a frame as make_panel() does. @param frame  [0, num_frames).
[[nodiscard]] PanelFrame panel_frame(const PanelLayout& layout, int frame, const RunControl& control = {});
[[nodiscard]] PanelFigures panel_figures(const PanelLayout& layout, const PanelMarks& marks, double hours);
[[nodiscard]] std::vector<PanelSpot> panel_spots(const PanelLayout& layout);
/// Share of each pixel that lies in the test area.
[[nodiscard]] ImageF test_area_shares(const PanelLayout& layout);

}  // namespace patinate::datasets
