/// \file
/// window_kernel.inl for C++.
#pragma once

#include <string_view>

#include "transfer/synthesis/search_kernel.h"

namespace patinate::transfer {

namespace window_kernel {
using namespace search_kernel;
#include "transfer/synthesis/window_kernel.inl"
}  // namespace window_kernel

/// The text of window_kernel.inl, of window_group.cl, and of window_device.cl.
extern const std::string_view kWindowKernel, kWindowGroup, kWindowEntries;

/// Pixels [x0, x1) x [y0, y1).
using window_kernel::SearchWindow;

}  // namespace patinate::transfer
