/// \file
/// Whether a device does iterations as the CPU does.
#pragma once

#include "libcommon/device/arithmetic_check.h"
#include "patinate/simulation/scene.h"

namespace patinate::simulation {

/// Hills with seams in the rain: drops bounce, float and follow what is wet, in splats of `splat_mm` (0: of one texel);
/// rules have every kind of step, and materials every kind of look.
[[nodiscard]] Scene check_scene(double splat_mm);

/// Iterations of it there and here, with splats of one texel, of a few, and of hundreds: some thousand gammatons, all
/// amounts, what maps counted and what is composed are compared. @throws DeviceError if the device cannot run it.
[[nodiscard]] device::CheckResult check_iterations(const device::Device& device);

}  // namespace patinate::simulation
