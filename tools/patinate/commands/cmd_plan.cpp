#include <nlohmann/json.hpp>

#include "libcommon/core/printable.h"
#include "tools/patinate/command_line/message_stream.h"
#include "tools/patinate/command_line/plan_file.h"
#include "tools/patinate/command_line/planned_command.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

int cmd_plan(CommandRun& run) {
  std::string verb;
  std::vector<std::string> rest;
  run.line.positional("COMMAND", "A command with its arguments, as it would be given without `cluster plan`", verb);
  run.line.without({"seed", "force", "dry_run"});
  run.line.example("cluster plan ingest photos/capture.json -o copper --json > copper.json");
  run.line.example("cluster plan render aged -o aged_%04d.png --frames 200");
  if (run.is_only_declared() || run.first_positional().empty()) {
    (void)run.parse();
    return 0;
  }
  PlanRequest request;
  bool is_json = false;
  const int code = ask_command(run.arguments(), request, run.stop(), is_json);
  if (!request.work) return code;  // Only its help was asked for.
  const std::vector<std::string> command = by_present_name(without_manners(run.arguments()));
  run.print((is_json ? printable_json(plan_json(command, *request.work)) : printable_lines(plan_text(*request.work))) +
            "\n");
  return code;
}

}  // namespace patinate::cli
