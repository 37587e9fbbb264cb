/// \file
/// Light that a surface throws into its own hollows, gathered from the photographs.
#pragma once

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

struct Interreflection {
  ImageF irradiance;          ///< H x W x L C, as UnlightResult::indirect.
  double unseen_share = 0.0;  ///< Share of the rays that met the surface where the camera does not see it.
};

/// Light that arrives at every texel from the rest of the blockers under each lamp. A photograph holds the light that
/// leaves every place it shows, however often that was thrown to and fro; where it is saturated or a highlight,
/// `fitted` says what a matt surface would show. Places that the camera does not see have the median albedo and the
/// lamp's light alone. 256 stratified rays from each texel of a grid, which others of the same surface are interpolated
/// from.
/// @param fitted  Of all texels, without interreflection.
/// @throws InvalidInput without blockers. Same bits for any number of threads.
[[nodiscard]] Interreflection gather_interreflection(const UnlightWork& work, const UnlightResult& fitted,
                                                     const RunControl& control);

/// How much of the clean samples of `result` it is; medians over determined texels.
[[nodiscard]] InterreflectionReport interreflection_shares(const UnlightWork& work, const UnlightResult& result);

}  // namespace patinate::capture
