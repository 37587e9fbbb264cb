#include "tests/support/lost_device.h"

namespace patinate::testing_support {

namespace {

int launches_left = 0;

cl_int launch_or_fail(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const std::size_t* first,
                      const std::size_t* size, const std::size_t* group, cl_uint num_events, const cl_event* events,
                      cl_event* event) {
  if (launches_left-- <= 0) return CL_OUT_OF_RESOURCES;
  return device::opencl()->clEnqueueNDRangeKernel(queue, kernel, dimensions, first, size, group, num_events, events,
                                                  event);
}

}  // namespace

const device::OpenCl& driver_with_launches(int num_launches) {
  static device::OpenCl failing = *device::opencl();
  failing.clEnqueueNDRangeKernel = &launch_or_fail;
  launches_left = num_launches;
  return failing;
}

}  // namespace patinate::testing_support
