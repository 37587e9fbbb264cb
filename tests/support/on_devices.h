/// \file
/// Tests that need an OpenCL device.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "libcommon/device/device.h"

namespace patinate::testing_support {

/// Skipped where there is none. @tparam Base  testing::Test or testing::TestWithParam.
template <class Base = testing::Test>
class OnDevices : public Base {
 protected:
  void SetUp() override {
    if (all.empty()) GTEST_SKIP() << "there is no OpenCL device (Debian: pocl-opencl-icd)";
  }
  std::vector<device::DeviceInfo> all = device::list_devices();
};

}  // namespace patinate::testing_support
