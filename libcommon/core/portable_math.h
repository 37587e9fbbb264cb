/// \file
/// exp, log, pow, sine and cosine from additions, multiplications and divisions alone: the same bits for every
/// instruction set, C library and device, as libm's are not (tested on x86-64). For whatever decides in a simulation.
/// Compiled with -ffp-contract=off (cmake/PatinateFlags.cmake). Argument reduction after [Cody and Waite 1980], series
/// by Horner's rule. Checked against libm over the whole range.
#pragma once

#include "libcommon/core/kernel_language.h"

namespace patinate {

/// portable_math.inl for C++, where each function says its range and error; devices read the same text.
namespace portable_kernel {
using namespace kernel_types;
#include "libcommon/core/portable_math.inl"
}  // namespace portable_kernel
/// The text of portable_math.inl.
extern const std::string_view kPortableMath;

using portable_kernel::portable_decayed;
using portable_kernel::portable_exp;
using portable_kernel::portable_log;
using portable_kernel::portable_pow;
using portable_kernel::portable_sine_cosine;
using portable_kernel::SineCosine;

}  // namespace patinate
