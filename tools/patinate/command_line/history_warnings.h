/// \file
/// What a history warns of: where it is made, and where it is used.
#pragma once

#include <string>
#include <vector>

#include "patinate/history/history_value.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// A line for each of the worst warnings, under the history's name, and one that counts the others: of the command that
/// makes the history.
/// @param label  What messages call the history.
void say_history_warnings(CommandRun& run, const std::string& label, const std::vector<HistoryWarning>& warnings);

/// One line in all, which says where they are said: of commands that use the history.
void refer_to_history_warnings(CommandRun& run, const std::string& label, const std::vector<HistoryWarning>& warnings);
/// That line; empty without warnings.
[[nodiscard]] std::string history_warnings_line(const std::string& label, const std::vector<HistoryWarning>& warnings);

}  // namespace patinate::cli
