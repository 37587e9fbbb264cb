/// \file
/// What a command says while its work is made ready.
#pragma once

#include "app/request/words.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// With --verbose which it is, why others are not taken, and how long it calculated; that it has failed always; and its
/// name in run.json. @param run  Must outlive what is opened.
[[nodiscard]] app::Words words_of(CommandRun& run);

}  // namespace patinate::cli
