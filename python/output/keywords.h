/// \file
/// Keywords that pictures and models share.
#pragma once

#include "app/request/times_choice.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

/// Says `time`, `times` and `num_times`.
FunctionText& times_text(FunctionText& text);
[[nodiscard]] app::TimesChoice times_from(Keywords& keywords);

}  // namespace patinate::python
