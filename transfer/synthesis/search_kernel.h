/// \file
/// cost_kernel.inl and search_kernel.inl for C++: the tables that it reads, from what synthesis has.
#pragma once

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include <string_view>

#include "libcommon/atlas/texel_neighborhood.h"
#include "libcommon/core/random.h"
#include "transfer/synthesis/levels.h"

namespace patinate::transfer {

namespace search_kernel {
using namespace kernel_types;
using namespace neighbor_kernel;
using namespace random_kernel;
#include "transfer/synthesis/cost_kernel.inl"
#include "transfer/synthesis/search_kernel.inl"
}  // namespace search_kernel

/// The text of cost_kernel.inl, of search_kernel.inl, and of search_device.cl.
extern const std::string_view kCostKernel, kSearchKernel, kSearchEntries;

/// Valid as long as the level is.
[[nodiscard]] search_kernel::AlikeTables alike_tables(const SourceLevel& source);
/// Without similar pixels.
[[nodiscard]] search_kernel::SourceTables source_tables(const SourceLevel& source);

}  // namespace patinate::transfer
