/// \file
/// How much the surface faces a direction: light from the sun, dust from above, a viewer.
#pragma once

#include <array>

#include "patinate/controls/control_map.h"
#include "patinate/core/options.h"
#include "patinate/core/run_control.h"

namespace patinate {

/// Settings of facing_map().
struct FacingOptions {
  std::array<double, 3> direction{
      0.0, 1.0, 0.0};  ///< From the surface to where it comes from; any length > 0. Default: up in glTF.
};
void describe(OptionVisitor& visitor, FacingOptions& options);

/// max(0, n . d) with the shading normal n: the cosine law; what faces away gets nothing and is 0. Range [0, 1]
/// "cosine". Shadows are not looked at.
/// @throws InvalidInput if the direction has no length.
[[nodiscard]] ControlMap facing_map(const TexelMap& map, const FacingOptions& options = {},
                                    const RunControl& control = {});

}  // namespace patinate
