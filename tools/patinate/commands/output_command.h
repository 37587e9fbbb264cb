/// \file
/// An output's work run by a command.
#pragma once

#include "app/output/output_work.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// Says the notes, makes what is not up to date or, where that is asked for, tells or plans it, and reports.
/// @returns the command's exit code.
int run_output(CommandRun& run, const app::OutputWork& work);

}  // namespace patinate::cli
