/// \file
/// Photographs of a coated panel.
#pragma once

#include <array>

#include "datasets_synthetic/panel_layout.h"
#include "patinate/core/run_control.h"
#include "patinate/image/image.h"

namespace patinate::datasets {

/// L*a*b* of the paint at a time, without unevenness.
[[nodiscard]] std::array<double, 3> paint_lab(const PanelOptions& o, double hours);
/// Linear light that the panel sends to the camera, without blur and noise: paint, stains that it shows through, and in
/// each pixel cracks and rust by their shares.
[[nodiscard]] ImageF panel_light(const PanelLayout& layout, const PanelMarks& marks, double hours,
                                 const RunControl& control = {});
/// Photograph of it: blurred, then 8-bit sRGB codes with noise from (seed, frame, row). Codes are within 0.01
/// of the formula before rounding.
[[nodiscard]] ImageU8 panel_photo(const ImageF& light, const PanelOptions& o, int frame,
                                  const RunControl& control = {});

}  // namespace patinate::datasets
