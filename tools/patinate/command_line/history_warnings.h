/// \file
/// What a history warns of, where it is used.
#pragma once

#include <string>
#include <vector>

#include "patinate/history/history_value.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// A line for each of the worst warnings, under the history's name, and one that counts the others. Of a history of the
/// library one line in all: whoever uses it did not take its photographs.
/// @param label  What messages call the history.
void note_history_warnings(CommandRun& run, const std::string& label, const std::vector<HistoryWarning>& warnings);

}  // namespace patinate::cli
