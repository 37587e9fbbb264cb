/// \file
/// On how many threads something runs.
#pragma once

#include "patinate/core/run_control.h"

namespace patinate::testing_support {

[[nodiscard]] inline RunControl with_threads(int num_threads) {
  return {.on_progress = {}, .stop = {}, .num_threads = num_threads};
}

}  // namespace patinate::testing_support
