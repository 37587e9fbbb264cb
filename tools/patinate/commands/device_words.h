/// \file
/// What a command says of the device that it runs on.
#pragma once

#include "app/output/checked_devices.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// With --verbose which it is, why others are not taken, and how long it calculated; that it has failed always; and its
/// name in run.json. @param run  Must outlive what is opened.
[[nodiscard]] app::DeviceWords words_of(CommandRun& run);

}  // namespace patinate::cli
