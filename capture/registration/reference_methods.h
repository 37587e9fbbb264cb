/// \file
/// PCL's plain methods, kept for comparison.
#pragma once

#include "patinate/capture/registration.h"

namespace patinate::capture {

/// point-to-point, point-to-plane (normals of 20 neighbors) or generalized ICP of PCL, in single precision about the
/// scans' middles, partners at most kReferenceGate spacings apart. No search: `start` is needed. What comes out is
/// judged as register_pair() judges its own.
/// @param options  Its method says which; Symmetric is refused. @throws InvalidInput; CannotComplete if PCL, which is
/// in the module `patinate-pcl`, cannot be loaded.
[[nodiscard]] PairRegistration register_pair_with_pcl(const PointCloud& target, const PointCloud& source,
                                                      const RigidTransform& start, const RegistrationOptions& options,
                                                      const RunControl& control = {});

inline constexpr double kReferenceGate = 10.0;

}  // namespace patinate::capture
