/// \file
/// For C++: the dialect that kernels are written in (kernel_language.inl). Sources include kernels inside a namespace
/// with `using namespace ::patinate::kernel_types`.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "libcommon/core/kernel_language.inl"

namespace patinate::kernel_types {
using i8 = std::int8_t;
using u8 = std::uint8_t;
using i16 = std::int16_t;
using u16 = std::uint16_t;
using i32 = std::int32_t;
using u32 = std::uint32_t;
using i64 = std::int64_t;
using u64 = std::uint64_t;
}  // namespace patinate::kernel_types

namespace patinate {
/// The text of kernel_language.inl.
extern const std::string_view kKernelLanguage;
}  // namespace patinate
