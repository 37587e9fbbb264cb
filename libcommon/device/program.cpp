#include <algorithm>
#include <utility>

#include "libcommon/core/files.h"
#include "libcommon/core/hash.h"
#include "libcommon/core/kernel_language.h"
#include "libcommon/core/user_cache.h"
#include "libcommon/device/device_state.h"

namespace patinate::device {

namespace fs = std::filesystem;

namespace {

/// Subnormals stay: -cl-denorms-are-zero is not given.
constexpr const char* kBuildOptions = "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt";

std::string build_log(const DeviceState& device, cl_program program) {
  std::size_t size = 0;
  if (device.cl.clGetProgramBuildInfo(program, device.id, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size) != CL_SUCCESS)
    return {};
  std::string log(size, '\0');
  device.cl.clGetProgramBuildInfo(program, device.id, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
  log.resize(std::min(log.size(), log.find('\0')));
  return log;
}

/// Where compiled programs of these sources and this driver are kept; empty where nothing can be.
fs::path cached_program(const DeviceInfo& info, std::string_view options, std::span<const std::string_view> sources) {
  const fs::path folder = user_cache_folder();
  if (folder.empty()) return {};
  ContentHash key;
  key.add(info.platform).add(info.name).add(info.driver).add(options);
  for (const std::string_view source : sources) key.add(source);
  return folder / "kernels" / (key.hex() + ".bin");
}

/// Drivers may crash on a program that is not whole: it is kept behind its own checksum.
constexpr std::size_t kChecksumSize = 32;

std::string checksum(std::string_view bytes) { return ContentHash().add(bytes).hex(); }

/// Null unless the file holds a whole program that the driver takes.
cl_program program_from(const DeviceState& device, const fs::path& file, const std::string& options) {
  std::error_code error;
  if (file.empty() || !fs::exists(file, error)) return nullptr;
  std::string bytes;
  try {
    bytes = read_file(file, std::uint64_t{1} << 28);
  } catch (const InputError&) {
    return nullptr;
  }
  if (bytes.size() <= kChecksumSize ||
      checksum(std::string_view(bytes).substr(kChecksumSize)) != bytes.substr(0, kChecksumSize))
    return nullptr;
  bytes.erase(0, kChecksumSize);
  const std::size_t size = bytes.size();
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  cl_int status = CL_SUCCESS, code = CL_SUCCESS;
  const cl_program program =
      device.cl.clCreateProgramWithBinary(device.context, 1, &device.id, &size, &data, &status, &code);
  if (code != CL_SUCCESS) return nullptr;
  if (status == CL_SUCCESS &&
      device.cl.clBuildProgram(program, 1, &device.id, options.c_str(), nullptr, nullptr) == CL_SUCCESS)
    return program;
  device.cl.clReleaseProgram(program);
  return nullptr;
}

/// Programs that cannot be kept are compiled again.
void keep(const DeviceState& device, cl_program program, const fs::path& file) {
  std::size_t size = 0;
  if (file.empty() ||
      device.cl.clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof(size), &size, nullptr) != CL_SUCCESS ||
      size == 0)
    return;
  std::string bytes(size, '\0');
  auto* data = reinterpret_cast<unsigned char*>(bytes.data());
  if (device.cl.clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof(data), static_cast<void*>(&data), nullptr) !=
      CL_SUCCESS)
    return;
  try {
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    write_atomically(file, checksum(bytes) + bytes);
  } catch (const Error&) {
    return;
  }
}

}  // namespace

Program Device::build(std::string_view name, std::span<const std::string_view> sources) const {
  const DeviceState& device = *state_;
  if (!device.info.has_doubles || !device.info.rounds_correctly)
    throw DeviceError(device.info.name + (device.info.has_doubles ? ": does not round divisions correctly"
                                                                  : ": has no numbers of double precision"));
  std::vector<std::string_view> all{kKernelLanguage};
  all.insert(all.end(), sources.begin(), sources.end());
  const std::string options = kBuildOptions;
  const fs::path file = cached_program(device.info, options, all);
  auto state = std::make_shared<ProgramState>(state_);
  state->program = program_from(device, file, options);
  if (state->program != nullptr) return Program(std::move(state));

  std::vector<const char*> texts;
  std::vector<std::size_t> lengths;
  for (const std::string_view source : all) {
    texts.push_back(source.data());
    lengths.push_back(source.size());
  }
  cl_int code = CL_SUCCESS;
  state->program = device.cl.clCreateProgramWithSource(device.context, static_cast<cl_uint>(texts.size()), texts.data(),
                                                       lengths.data(), &code);
  device.check(code, "taking the kernels of " + std::string(name));
  code = device.cl.clBuildProgram(state->program, 1, &device.id, options.c_str(), nullptr, nullptr);
  if (code != CL_SUCCESS) {
    throw DeviceError(device.info.name + ": its driver could not compile the kernels of " + std::string(name) + " (" +
                          std::string(opencl_error_name(code)) + ")",
                      build_log(device, state->program));
  }
  keep(device, state->program, file);
  return Program(std::move(state));
}

Kernel Program::kernel(const std::string& name) const {
  auto state = std::make_shared<KernelState>(state_, name);
  cl_int code = CL_SUCCESS;
  state->kernel = state_->device->cl.clCreateKernel(state_->program, name.c_str(), &code);
  state_->device->check(code, "making the kernel " + name);
  return Kernel(std::move(state));
}

void Kernel::set_memory(unsigned index, const Memory& memory) {
  auto* handle = static_cast<cl_mem>(memory.handle_.get());
  set_value(index, static_cast<const void*>(&handle), sizeof(cl_mem));
  state_->arguments[index].memory = memory.handle_;
}

void Kernel::set_value(unsigned index, const void* value, std::size_t size) {
  std::vector<KernelState::Argument>& arguments = state_->arguments;
  if (arguments.size() <= index) arguments.resize(index + std::size_t{1});
  const std::span<const std::byte> bytes(static_cast<const std::byte*>(value), size);
  KernelState::Argument& argument = arguments[index];
  if (std::equal(bytes.begin(), bytes.end(), argument.value.begin(), argument.value.end())) return;
  const DeviceState& device = *state_->program->device;
  argument.value.clear();
  device.check(device.cl.clSetKernelArg(state_->kernel, index, size, value),
               "giving " + state_->name + " its argument " + std::to_string(index));
  argument.value.assign(bytes.begin(), bytes.end());
}

void Kernel::launch(const Items& items) { state_->program->device->launch(state_->kernel, state_->name, items); }

}  // namespace patinate::device
