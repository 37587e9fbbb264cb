/// \file
/// The OpenCL functions that we call, found when the program runs: a machine without libOpenCL has no devices, and
/// notices nothing else (docs/decisions/0014-opencl.md).
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <string_view>

namespace patinate::device {

#define PATINATE_OPENCL_FUNCTIONS(each)                                                                             \
  each(clBuildProgram) each(clCreateBuffer) each(clCreateCommandQueue) each(clCreateContext) each(clCreateKernel)   \
      each(clCreateProgramWithBinary) each(clCreateProgramWithSource) each(clEnqueueFillBuffer)                     \
          each(clEnqueueNDRangeKernel) each(clEnqueueReadBuffer) each(clEnqueueWriteBuffer) each(clFinish)          \
              each(clGetDeviceIDs) each(clGetDeviceInfo) each(clGetEventProfilingInfo) each(clGetPlatformIDs)       \
                  each(clGetPlatformInfo) each(clGetProgramBuildInfo) each(clGetProgramInfo)                        \
                      each(clReleaseCommandQueue) each(clReleaseContext) each(clReleaseEvent) each(clReleaseKernel) \
                          each(clReleaseMemObject) each(clReleaseProgram) each(clSetKernelArg)

/// A table of them: tests put functions that fail into a copy.
struct OpenCl {
#define PATINATE_OPENCL_MEMBER(name) decltype(&::name) name = nullptr;
  PATINATE_OPENCL_FUNCTIONS(PATINATE_OPENCL_MEMBER)
#undef PATINATE_OPENCL_MEMBER
};

/// Functions of the library that $PATINATE_OPENCL names (a path; `none` stands for a machine without it), else of
/// libOpenCL.so.1; loaded by the first call. Null where there is none.
[[nodiscard]] const OpenCl* opencl();

/// "CL_OUT_OF_RESOURCES"; "an error" for one that we do not know.
[[nodiscard]] std::string_view opencl_error_name(cl_int code);

}  // namespace patinate::device
