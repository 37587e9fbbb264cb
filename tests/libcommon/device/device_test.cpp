#include "libcommon/device/device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include "libcommon/device/arithmetic_check.h"
#include "libcommon/device/device_choice.h"
#include "libcommon/device/opencl.h"
#include "tests/support/temp_folder.h"

namespace patinate::device {
namespace {

using testing_support::TempFolder;

/// Every device of this machine; PoCL's in CI.
class Devices : public ::testing::Test {
 protected:
  void SetUp() override {
    if (all.empty()) GTEST_SKIP() << "there is no OpenCL device (Debian: pocl-opencl-icd)";
  }
  std::vector<DeviceInfo> all = list_devices();
};

TEST_F(Devices, CalculateAsTheCpuDoes) {
  for (const DeviceInfo& info : all) {
    const CheckResult check = check_arithmetic(Device(info));
    EXPECT_EQ(check.num_different, 0) << label(info);
    EXPECT_GT(check.num_items, 1000);
  }
}

TEST_F(Devices, GiveBackWhatWasWritten) {
  const Device device(all[0]);
  std::vector<std::int32_t> values(1000);
  std::iota(values.begin(), values.end(), -500);
  const Buffer<std::int32_t> buffer = device.upload(values);
  std::vector<std::int32_t> read(values.size());
  device.read(buffer, std::span(read));
  EXPECT_EQ(read, values);
  device.fill_zero(buffer.memory());
  device.read(buffer, std::span(read));
  EXPECT_EQ(std::count(read.begin(), read.end(), 0), 1000);
}

TEST_F(Devices, WriteFromAnyPlaceOfABufferOnAndNotBeyondIt) {
  const Device device(all[0]);
  Buffer<std::int32_t> buffer = device.upload(std::vector<std::int32_t>(6, -1));
  const std::vector<std::int32_t> two{7, 8};
  device.write(std::span<const std::int32_t>(two), buffer, 4);
  std::vector<std::int32_t> read(6);
  device.read(buffer, std::span(read));
  EXPECT_EQ(read, (std::vector<std::int32_t>{-1, -1, -1, -1, 7, 8}));
  for (const std::size_t first : {std::size_t{5}, std::size_t{6}, std::size_t{100}})
    EXPECT_THROW(device.write(std::span<const std::int32_t>(two), buffer, first), InvalidInput) << first;
}

TEST_F(Devices, RunItemsFromAFirstOneOn) {
  const Device device(all[0]);
  const std::array<std::string_view, 1> source{
      "kernel void square(int add, global int* out) { const int i = (int)get_global_id(0); out[i] = i * i + add; }"};
  Kernel kernel = device.build("squares", source).kernel("square");
  Buffer<std::int32_t> out = device.upload(std::vector<std::int32_t>(10, -1));
  kernel.run({.first = 3, .num = 4}, std::int32_t{100}, out);
  std::vector<std::int32_t> read(10);
  device.read(out, std::span(read));
  EXPECT_EQ(read, (std::vector<std::int32_t>{-1, -1, -1, 109, 116, 125, 136, -1, -1, -1}));
}

TEST_F(Devices, SayWhatTheirCompilerSaid) {
  const std::array<std::string_view, 1> source{"kernel void broken(global int* out) { out[0] = undeclared_name; }"};
  try {
    (void)Device(all[0]).build("broken kernels", source);
    FAIL() << "compiled";
  } catch (const DeviceError& e) {
    EXPECT_NE(std::string(e.what()).find("could not compile the kernels of broken kernels"), std::string::npos)
        << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    EXPECT_NE(e.detail().find("undeclared_name"), std::string::npos);
  }
}

TEST_F(Devices, RefuseABufferThatIsTooLarge) {
  DeviceInfo small = all[0];
  small.largest_buffer_bytes = 1000;
  const Device device(small);
  (void)device.allocate<std::uint8_t>(1000);
  EXPECT_THROW((void)device.allocate<std::uint8_t>(1001), DeviceError);
}

/// A broken file among the kept programs is as none.
TEST_F(Devices, CompileAgainWhenAKeptProgramIsBroken) {
  const TempFolder cache;
  const char* before = std::getenv("XDG_CACHE_HOME");
  const std::string kept = before == nullptr ? "" : before;
  ::setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  const Device device(all[0]);
  const std::array<std::string_view, 1> source{"kernel void one(global int* out) { out[0] = 1; }"};
  const auto run = [&] {
    Kernel kernel = device.build("one", source).kernel("one");
    const Buffer<std::int32_t> out = device.allocate<std::int32_t>(1);
    kernel.run({.num = 1}, out);
    std::array<std::int32_t, 1> read{};
    device.read(out, std::span<std::int32_t>(read));
    return read[0];
  };
  EXPECT_EQ(run(), 1);
  int num_files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(cache.path() / "patinate" / "kernels")) {
    ++num_files;
    std::filesystem::resize_file(entry.path(), std::filesystem::file_size(entry.path()) / 2);
  }
  EXPECT_EQ(num_files, 1);
  EXPECT_EQ(run(), 1);
  if (before == nullptr) {
    ::unsetenv("XDG_CACHE_HOME");
  } else {
    ::setenv("XDG_CACHE_HOME", kept.c_str(), 1);
  }
}

TEST_F(Devices, ThatAreLostSayWhatFailed) {
  static OpenCl failing = *opencl();
  failing.clEnqueueNDRangeKernel = [](cl_command_queue, cl_kernel, cl_uint, const std::size_t*, const std::size_t*,
                                      const std::size_t*, cl_uint, const cl_event*,
                                      cl_event*) -> cl_int { return CL_DEVICE_NOT_AVAILABLE; };
  try {
    (void)check_arithmetic(Device(all[0], failing));
    FAIL() << "ran";
  } catch (const DeviceError& e) {
    EXPECT_NE(std::string(e.what()).find("running check_arithmetic failed (CL_DEVICE_NOT_AVAILABLE"), std::string::npos)
        << e.what();
  }
}

DeviceInfo named(const std::string& name, const std::string& platform, bool is_gpu) {
  DeviceInfo info;
  info.name = name;
  info.platform = platform;
  info.is_gpu = is_gpu;
  return info;
}

TEST(ChooseDevices, TakesGpusByThemselvesAndOthersByName) {
  const std::vector<DeviceInfo> all{named("pthread-cpu", "Portable Computing Language", false),
                                    named("NVIDIA H200", "NVIDIA CUDA", true)};
  EXPECT_EQ(choose_devices("auto", all).at(0).name, "NVIDIA H200");
  EXPECT_EQ(choose_devices("gpu", all).at(0).name, "NVIDIA H200");
  EXPECT_TRUE(choose_devices("cpu", all).empty());
  EXPECT_EQ(choose_devices("PORTABLE", all).at(0).name, "pthread-cpu");
  EXPECT_TRUE(choose_devices("auto", {all[0]}).empty()) << "a CPU's own code is faster than PoCL's";
}

TEST(ChooseDevices, NamesWhatThereIsWhenNothingFits) {
  const std::vector<DeviceInfo> all{named("NVIDIA H200", "NVIDIA CUDA", true)};
  const auto message = [](const std::string& device, const std::vector<DeviceInfo>& devices) -> std::string {
    try {
      (void)choose_devices(device, devices);
    } catch (const InvalidInput& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(message("vega", all), "--device: found `vega`; there is NVIDIA H200 (NVIDIA CUDA); or auto, cpu");
  EXPECT_EQ(message("gpu", {}), "--device: found `gpu`; OpenCL has no devices here; or auto, cpu");
}

}  // namespace
}  // namespace patinate::device
