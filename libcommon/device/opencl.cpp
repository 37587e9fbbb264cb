#include "libcommon/device/opencl.h"

#include <dlfcn.h>

#include <cstdlib>
#include <optional>
#include <string>

namespace patinate::device {

namespace {

std::optional<OpenCl> load() {
  const char* given = std::getenv("PATINATE_OPENCL");
  const std::string file = given == nullptr || *given == '\0' ? "libOpenCL.so.1" : given;
  if (file == "none") return std::nullopt;
  void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return std::nullopt;
  OpenCl functions;
  bool is_whole = true;
#define PATINATE_FIND(name)                                                      \
  functions.name = reinterpret_cast<decltype(&::name)>(::dlsym(library, #name)); \
  is_whole = is_whole && functions.name != nullptr;
  PATINATE_OPENCL_FUNCTIONS(PATINATE_FIND)
#undef PATINATE_FIND
  if (!is_whole) return std::nullopt;
  return functions;
}

}  // namespace

const OpenCl* opencl() {
  static const std::optional<OpenCl> functions = load();
  return functions ? &*functions : nullptr;
}

std::string_view opencl_error_name(cl_int code) {
#define PATINATE_NAME(name) \
  case name:                \
    return #name;
  switch (code) {
    PATINATE_NAME(CL_DEVICE_NOT_FOUND)
    PATINATE_NAME(CL_DEVICE_NOT_AVAILABLE)
    PATINATE_NAME(CL_COMPILER_NOT_AVAILABLE)
    PATINATE_NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE)
    PATINATE_NAME(CL_OUT_OF_RESOURCES)
    PATINATE_NAME(CL_OUT_OF_HOST_MEMORY)
    PATINATE_NAME(CL_BUILD_PROGRAM_FAILURE)
    PATINATE_NAME(CL_INVALID_VALUE)
    PATINATE_NAME(CL_INVALID_DEVICE)
    PATINATE_NAME(CL_INVALID_BUFFER_SIZE)
    PATINATE_NAME(CL_INVALID_BINARY)
    PATINATE_NAME(CL_INVALID_BUILD_OPTIONS)
    PATINATE_NAME(CL_INVALID_KERNEL_NAME)
    PATINATE_NAME(CL_INVALID_KERNEL_ARGS)
    PATINATE_NAME(CL_INVALID_ARG_INDEX)
    PATINATE_NAME(CL_INVALID_ARG_SIZE)
    PATINATE_NAME(CL_INVALID_WORK_GROUP_SIZE)
    PATINATE_NAME(CL_INVALID_COMMAND_QUEUE)
    default:
      return "an error";
  }
#undef PATINATE_NAME
}

}  // namespace patinate::device
