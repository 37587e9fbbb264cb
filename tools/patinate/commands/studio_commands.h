/// \file
/// The commands that `patinate studio` starts for a browser.
#pragma once

#include <string>
#include <vector>

#include "tools/studio/job_commands.h"

namespace patinate::cli {

/// A fixed list. Options that read or write elsewhere, or that say how a command is run, are left out.
[[nodiscard]] std::vector<studio::JobCommand> studio_commands();
/// @param arguments  What follows the verb. @throws Error saying what is wrong with them, before an input is opened.
void check_studio_command(const std::string& verb, const std::vector<std::string>& arguments);

}  // namespace patinate::cli
