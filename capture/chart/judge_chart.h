/// \file
/// Whether a photograph's chart has the colors of its table.
#pragma once

#include <string>

#include "capture/chart/chart_fit.h"

namespace patinate::capture {

/// Names patches that differ from the table by CIEDE2000 12 more than they do in most photographs: something lies over
/// them. Then a chart that differs by 5 on average: another make, or light that changes over it.
/// @returns As ChartPlace::problem; "" = nothing.
[[nodiscard]] std::string judge_chart(const ChartFit& fit, std::size_t photo, const ChartTable& table);

}  // namespace patinate::capture
