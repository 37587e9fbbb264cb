/// \file
/// Commands whose work can be planned, and asking them for it.
#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "tools/patinate/command_line/plan_request.h"

namespace patinate::cli {

/// Asks a command, as main() would run it, and takes its answer.
/// @param words  The verb and its arguments. @param is_json  Set to whether they hold --json.
/// @returns its exit code. @throws UsageError if there is no such command, or it cannot be planned.
int ask_command(const std::vector<std::string>& words, PlanRequest& request, std::stop_token stop, bool& is_json);

/// Without what changes no result: --json, --quiet, --verbose, --dry-run and --threads.
[[nodiscard]] std::vector<std::string> without_manners(const std::vector<std::string>& words);

}  // namespace patinate::cli
