/// \file
/// window_kernel.inl for C++.
#pragma once

#include "transfer/synthesis/search_kernel.h"

namespace patinate::transfer {

namespace window_kernel {
using namespace search_kernel;
#include "transfer/synthesis/window_kernel.inl"
}  // namespace window_kernel

/// Pixels [x0, x1) x [y0, y1).
using window_kernel::SearchWindow;

}  // namespace patinate::transfer
