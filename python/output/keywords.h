/// \file
/// Keywords that pictures and models share.
#pragma once

#include "python/support/keywords.h"
#include "python/support/signature.h"
#include "tools/patinate/command_line/times_choice.h"

namespace patinate::python {

/// Says `time`, `times` and `num_times`.
FunctionText& times_text(FunctionText& text);
[[nodiscard]] cli::TimesChoice times_from(Keywords& keywords);

}  // namespace patinate::python
