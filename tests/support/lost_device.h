/// \file
/// A driver that loses its device.
#pragma once

#include "libcommon/device/opencl.h"

namespace patinate::testing_support {

/// Driver of this machine, but for launches: so many work, those after them fail.
[[nodiscard]] const device::OpenCl& driver_with_launches(int num_launches);

}  // namespace patinate::testing_support
