/// \file
/// The commands of patinate, one a file (`cmd_*.cpp`).
#pragma once

#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

/// Each returns the exit code (0, or 3 from `validate`), or throws an error of libcommon/include/patinate/core/error.h.
int cmd_accessibility(CommandRun& run);
int cmd_calibrate(CommandRun& run);
int cmd_combine(CommandRun& run);
int cmd_compare(CommandRun& run);
int cmd_completion(CommandRun& run);
int cmd_control(CommandRun& run);
int cmd_devices(CommandRun& run);
int cmd_evaluate(CommandRun& run);
int cmd_explain(CommandRun& run);
int cmd_export(CommandRun& run);
int cmd_factorize(CommandRun& run);
int cmd_field(CommandRun& run);
int cmd_fit(CommandRun& run);
int cmd_grade(CommandRun& run);
int cmd_height_change(CommandRun& run);
int cmd_help(CommandRun& run);
int cmd_info(CommandRun& run);
int cmd_ingest(CommandRun& run);
int cmd_init(CommandRun& run);
int cmd_join(CommandRun& run);
int cmd_library(CommandRun& run);
int cmd_material(CommandRun& run);
int cmd_plan(CommandRun& run);
int cmd_rank(CommandRun& run);
int cmd_register(CommandRun& run);
int cmd_render(CommandRun& run);
int cmd_restyle(CommandRun& run);
int cmd_run(CommandRun& run);
int cmd_simulate(CommandRun& run);
int cmd_studio(CommandRun& run);
int cmd_study(CommandRun& run);
int cmd_synth(CommandRun& run);
int cmd_texture(CommandRun& run);
int cmd_thickness(CommandRun& run);
int cmd_transfer(CommandRun& run);
int cmd_trim(CommandRun& run);
int cmd_unlight(CommandRun& run);
int cmd_validate(CommandRun& run);

}  // namespace patinate::cli
