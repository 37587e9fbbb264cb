#include "libcommon/device/device.h"

#include <algorithm>
#include <array>
#include <utility>

#include "libcommon/core/stopwatch.h"
#include "libcommon/device/device_state.h"

namespace patinate::device {

namespace {

/// Answer of an OpenCL query, a text or a number.
template <class Query>
std::string text_of(const Query& query) {
  std::size_t size = 0;
  if (query(0, nullptr, &size) != CL_SUCCESS || size == 0) return {};
  std::string text(size, '\0');
  if (query(size, text.data(), nullptr) != CL_SUCCESS) return {};
  text.resize(std::min(text.size(), text.find('\0')));
  // Drivers pad names with blanks.
  const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

DeviceInfo describe_device(const OpenCl& cl, cl_platform_id platform, cl_device_id id) {
  const auto ask = [&](cl_device_info what) {
    return text_of(
        [&](std::size_t n, void* to, std::size_t* size) { return cl.clGetDeviceInfo(id, what, n, to, size); });
  };
  const auto number = [&]<class T>(cl_device_info what, T value) {
    cl.clGetDeviceInfo(id, what, sizeof(T), &value, nullptr);
    return value;
  };
  DeviceInfo info;
  info.name = ask(CL_DEVICE_NAME);
  const auto ask_platform = [&](cl_platform_info what) {
    return text_of(
        [&](std::size_t n, void* to, std::size_t* size) { return cl.clGetPlatformInfo(platform, what, n, to, size); });
  };
  info.platform = ask_platform(CL_PLATFORM_NAME);
  info.version = ask_platform(CL_PLATFORM_VERSION);
  info.driver = ask(CL_DRIVER_VERSION);
  info.is_gpu = (number(CL_DEVICE_TYPE, cl_device_type{0}) & CL_DEVICE_TYPE_GPU) != 0;
  info.num_units = static_cast<int>(number(CL_DEVICE_MAX_COMPUTE_UNITS, cl_uint{0}));
  info.memory_bytes = number(CL_DEVICE_GLOBAL_MEM_SIZE, cl_ulong{0});
  info.largest_buffer_bytes = number(CL_DEVICE_MAX_MEM_ALLOC_SIZE, cl_ulong{0});
  info.has_doubles = number(CL_DEVICE_DOUBLE_FP_CONFIG, cl_device_fp_config{0}) != 0;
  info.rounds_correctly =
      (number(CL_DEVICE_SINGLE_FP_CONFIG, cl_device_fp_config{0}) & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.platform_handle = platform;
  info.device_handle = id;
  return info;
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
  const OpenCl* functions = opencl();
  return functions == nullptr ? std::vector<DeviceInfo>() : list_devices(*functions);
}

std::vector<DeviceInfo> list_devices(const OpenCl& cl) {
  constexpr cl_uint kMost = 64;  // Platforms, and devices of each.
  std::array<cl_platform_id, kMost> platforms{};
  cl_uint num_platforms = 0;
  std::vector<DeviceInfo> found;
  if (cl.clGetPlatformIDs(kMost, platforms.data(), &num_platforms) != CL_SUCCESS) return found;
  for (cl_uint p = 0; p < std::min(num_platforms, kMost); ++p) {
    std::array<cl_device_id, kMost> devices{};
    cl_uint num_devices = 0;
    if (cl.clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, kMost, devices.data(), &num_devices) != CL_SUCCESS)
      continue;
    for (cl_uint d = 0; d < std::min(num_devices, kMost); ++d)
      found.push_back(describe_device(cl, platforms[p], devices[d]));
  }
  return found;
}

void DeviceState::check(cl_int code, const std::string& what) const {
  if (code != CL_SUCCESS)
    throw DeviceError(info.name + ": " + what + " failed (" + std::string(opencl_error_name(code)) + ", " +
                      std::to_string(code) + ")");
}

namespace {

const OpenCl& opencl_or_throw(const DeviceInfo& info) {
  const OpenCl* functions = opencl();
  if (functions == nullptr) throw DeviceError(info.name + ": there is no OpenCL");
  return *functions;
}

}  // namespace

Device::Device(const DeviceInfo& info) : Device(info, opencl_or_throw(info)) {}

Device::Device(const DeviceInfo& info, const OpenCl& functions)
    : state_(std::make_shared<DeviceState>(info, functions)) {
  DeviceState& s = *state_;
  cl_int code = CL_SUCCESS;
  s.context = s.cl.clCreateContext(nullptr, 1, &s.id, nullptr, nullptr, &code);
  s.check(code, "opening it");
  s.queue = s.cl.clCreateCommandQueue(s.context, s.id, CL_QUEUE_PROFILING_ENABLE, &code);
  s.check(code, "making a queue");
}

DeviceState::~DeviceState() {
  if (queue != nullptr && !writes.empty()) cl.clFinish(queue);
  for (const Launch& launch : launches) cl.clReleaseEvent(launch.event);
  if (queue != nullptr) cl.clReleaseCommandQueue(queue);
  if (context != nullptr) cl.clReleaseContext(context);
}

const DeviceInfo& Device::info() const { return state_->info; }

Memory Device::allocate_bytes(std::size_t size) const {
  const DeviceState& s = *state_;
  if (size > s.info.largest_buffer_bytes) {
    throw DeviceError(s.info.name + ": too little memory (" + std::to_string(size >> 20) +
                      " MB in one piece; it gives " + std::to_string(s.info.largest_buffer_bytes >> 20) + ")");
  }
  cl_int code = CL_SUCCESS;
  const cl_mem memory =
      s.cl.clCreateBuffer(s.context, CL_MEM_READ_WRITE, std::max<std::size_t>(size, 1), nullptr, &code);
  s.check(code, "allocating " + std::to_string(size >> 20) + " MB");
  Memory result;
  result.size_bytes_ = size;
  result.handle_ = std::shared_ptr<void>(
      memory, [device = state_](void* m) { device->cl.clReleaseMemObject(static_cast<cl_mem>(m)); });
  return result;
}

void Device::write_bytes(const Memory& memory, std::size_t offset, const void* values, std::size_t size) const {
  if (offset > memory.size_bytes_ || size > memory.size_bytes_ - offset)
    throw InvalidInput("a device's buffer is shorter than what is written to it");
  if (size == 0) return;
  const DeviceState& s = *state_;
  const std::lock_guard lock(s.mutex);
  const Stopwatch watch(s.times.copies_s);
  s.times.copied_bytes += size;
  ++s.times.num_copies;
  s.check(s.cl.clEnqueueWriteBuffer(s.queue, static_cast<cl_mem>(memory.handle_.get()), CL_TRUE, offset, size, values,
                                    0, nullptr, nullptr),
          "writing to it");
}

void Device::read_bytes(const Memory& memory, void* values, std::size_t size) const {
  if (size > memory.size_bytes_) throw InvalidInput("a device's buffer is shorter than what is read from it");
  if (size == 0) return;
  const DeviceState& s = *state_;
  const std::lock_guard lock(s.mutex);
  s.finish();
  const Stopwatch watch(s.times.copies_s);
  s.times.copied_bytes += size;
  ++s.times.num_copies;
  s.check(s.cl.clEnqueueReadBuffer(s.queue, static_cast<cl_mem>(memory.handle_.get()), CL_TRUE, 0, size, values, 0,
                                   nullptr, nullptr),
          "reading from it");
}

void Device::write_bytes_soon(const Memory& memory, std::span<const std::byte> values) const {
  constexpr std::size_t kMaxWrites = 1024;
  if (values.size() > memory.size_bytes_) throw InvalidInput("a device's buffer is shorter than what is written to it");
  if (values.empty()) return;
  const DeviceState& s = *state_;
  const std::lock_guard lock(s.mutex);
  if (s.writes.size() >= kMaxWrites) s.finish();
  const std::vector<std::byte>& kept = s.writes.emplace_back(values.begin(), values.end());
  s.times.copied_bytes += kept.size();
  ++s.times.num_copies;
  s.check(s.cl.clEnqueueWriteBuffer(s.queue, static_cast<cl_mem>(memory.handle_.get()), CL_FALSE, 0, kept.size(),
                                    kept.data(), 0, nullptr, nullptr),
          "writing to it");
}

void Device::fill_words(const Memory& memory, std::uint32_t word) const {
  if (memory.size_bytes_ == 0) return;
  const DeviceState& s = *state_;
  const std::lock_guard lock(s.mutex);
  const std::size_t size = memory.size_bytes_ % sizeof(word) == 0 ? sizeof(word) : 1;
  s.check(s.cl.clEnqueueFillBuffer(s.queue, static_cast<cl_mem>(memory.handle_.get()), &word, size, 0,
                                   memory.size_bytes_, 0, nullptr, nullptr),
          "filling memory");
}

void DeviceState::finish() const {
  const std::lock_guard lock(mutex);
  const cl_int code = cl.clFinish(queue);
  for (const auto& [event, kernel] : launches) {
    cl_ulong begin = 0, end = 0;  // ns
    if (code == CL_SUCCESS &&
        cl.clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof(begin), &begin, nullptr) == CL_SUCCESS &&
        cl.clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof(end), &end, nullptr) == CL_SUCCESS &&
        end > begin) {
      const double seconds = 1e-9 * static_cast<double>(end - begin);
      times.kernels_s += seconds;
      kernel->seconds += seconds;
      ++kernel->num_launches;
    }
    cl.clReleaseEvent(event);
  }
  launches.clear();
  writes.clear();
  check(code, "waiting for it");
}

void DeviceState::launch(cl_kernel kernel, const std::string& name, const Items& items) const {
  constexpr std::size_t kMaxLaunches = 4096;  // Whose events are kept.
  if (items.num == 0) return;
  const std::lock_guard lock(mutex);
  if (launches.size() >= kMaxLaunches) finish();
  const std::size_t first = items.first, num = items.num, group = items.group;
  cl_event event = nullptr;
  check(cl.clEnqueueNDRangeKernel(queue, kernel, 1, &first, &num, group == 0 ? nullptr : &group, 0, nullptr, &event),
        "running " + name);
  launches.push_back({event, &times.kernels[name]});
}

void Device::finish() const { state_->finish(); }

DeviceTimes Device::times() const {
  const std::lock_guard lock(state_->mutex);
  return state_->times;
}

}  // namespace patinate::device
