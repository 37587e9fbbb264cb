/// \file
/// What a Device, its programs and kernels keep: handles of OpenCL. Included by their sources only.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "libcommon/device/device.h"
#include "libcommon/device/opencl.h"

namespace patinate::device {

struct DeviceState {
  DeviceState(const DeviceInfo& device_info, const OpenCl& functions)
      : info(device_info), cl(functions), id(static_cast<cl_device_id>(device_info.device_handle)) {}
  ~DeviceState();
  DeviceState(const DeviceState&) = delete;
  DeviceState& operator=(const DeviceState&) = delete;
  /// @throws DeviceError "NAME: WHAT failed (...)" unless the code is CL_SUCCESS.
  void check(cl_int code, const std::string& what) const;
  /// Waits for all that was queued, and adds what kernels took.
  void finish() const;
  /// Queues items of a kernel.
  void launch(cl_kernel kernel, const std::string& name, const Items& items) const;

  /// Guards the queue and what follows it: several threads may use a device.
  mutable std::recursive_mutex mutex;
  DeviceInfo info;
  const OpenCl& cl;
  cl_device_id id;
  cl_context context = nullptr;
  cl_command_queue queue = nullptr;
  mutable DeviceTimes times;
  struct Launch {
    cl_event event;
    DeviceTimes::Kernel* kernel;  ///< Entry of `times`.
  };
  mutable std::vector<Launch> launches;                ///< Since the last finish(),
  mutable std::vector<std::vector<std::byte>> writes;  ///< and what is on its way there.
};

struct ProgramState {
  std::shared_ptr<const DeviceState> device;
  cl_program program = nullptr;
  explicit ProgramState(std::shared_ptr<const DeviceState> its_device) : device(std::move(its_device)) {}
  ~ProgramState() {
    if (program != nullptr) device->cl.clReleaseProgram(program);
  }
  ProgramState(const ProgramState&) = delete;
  ProgramState& operator=(const ProgramState&) = delete;
};

struct KernelState {
  std::shared_ptr<const ProgramState> program;
  std::string name;
  cl_kernel kernel = nullptr;
  struct Argument {
    std::shared_ptr<void> memory = {};  ///< Alive as long as it is one.
    std::vector<std::byte> value = {};
  };
  std::vector<Argument> arguments;  ///< Arguments as they are set.
  KernelState(std::shared_ptr<const ProgramState> its_program, std::string its_name)
      : program(std::move(its_program)), name(std::move(its_name)) {}
  ~KernelState() {
    if (kernel != nullptr) program->device->cl.clReleaseKernel(kernel);
  }
  KernelState(const KernelState&) = delete;
  KernelState& operator=(const KernelState&) = delete;
};

}  // namespace patinate::device
