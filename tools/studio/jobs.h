/// \file
/// What the studio needs for jobs.
#pragma once

#include "tools/studio/job_commands.h"
#include "tools/studio/job_runner.h"

namespace patinate::studio {

struct Jobs {
  JobCommands commands;
  JobRunner runner;
};

}  // namespace patinate::studio
