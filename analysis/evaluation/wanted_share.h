/// \file
/// How much of a surface a feature would cover if it were as frequent as in the source wherever the same control is
/// wanted.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "analysis/evaluation/synthesized_map.h"
#include "patinate/image/image.h"

namespace patinate::analysis {

/// Texels by the value of a control that they want, in 64 bins of equal width over [0, 1].
using WantedCounts = std::array<std::int64_t, 64>;
/// @param part  With a control.
[[nodiscard]] WantedCounts count_wanted(const MapPart& part);

/// The share of `feature` among the source's pixels of a control, in those bins, weighted by how often the surface
/// wants it; of values that the source has nowhere, the nearest bin that it has.
/// @param feature,control,mask  Of the source, equal in size; `feature` and `mask` 0 = no, `mask` may be empty,
/// `control` in [0, 1]. @returns nothing if no pixel or no texel counts.
[[nodiscard]] std::optional<double> wanted_share(const ImageU8& feature, const ImageF& control, const ImageU8& mask,
                                                 const WantedCounts& wanted);

}  // namespace patinate::analysis
