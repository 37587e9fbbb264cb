#include <nlohmann/json.hpp>
#include <utility>

#include "tools/patinate/command_line/plan_file.h"
#include "tools/patinate/command_line/planned_command.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

/// Options of `cluster run` and `cluster join` that concern the planned command.
std::vector<std::string> with_manners(std::vector<std::string> command, const CommonOptions& common) {
  if (common.threads != 0) command.insert(command.end(), {"--threads", std::to_string(common.threads)});
  if (common.json) command.emplace_back("--json");
  if (common.quiet) command.emplace_back("--quiet");
  if (common.verbose) command.emplace_back("--verbose");
  return command;
}

/// States what is left, on stdout.
int report_planned_work(CommandRun& run, const PlanFile& plan) {
  PlanRequest request{.identity = plan.identity};
  bool is_json = false;
  (void)ask_command(plan.command, request, run.stop(), is_json);
  run.report(plan_json(plan.command, *request.work), plan_text(*request.work));
  return 0;
}

int answer_plan(CommandRun& run, const std::filesystem::path& file, PlanRequest request) {
  const PlanFile plan = read_plan_file(file);
  if (run.line.common().dry_run) return report_planned_work(run, plan);
  request.identity = plan.identity;
  bool is_json = false;
  return ask_command(with_manners(plan.command, run.line.common()), request, run.stop(), is_json);
}

}  // namespace

int cmd_run(CommandRun& run) {
  std::filesystem::path file;
  std::string items;
  run.line.positional(
      "PLAN", "A file that `patinate cluster plan` has made; or a command with its arguments, to be done whole", file);
  run.line.option("items", "LIST", "Which items: numbers and ranges, as 0-3,7; default: all", items);
  run.line.without({"seed", "force"});
  run.line.example("cluster run copper.json --items 12-19");
  run.line.example("cluster run copper.json --dry-run");
  run.line.example("cluster run transfer copper bust.glb --control accessibility -o aged");
  if (const auto found = find_verb(run.arguments()); !run.is_only_declared() && found && found->verb->is_planned) {
    PlanRequest request{.wanted = PlanRequest::Wanted::Whole};
    bool is_json = false;
    return ask_command(run.arguments(), request, run.stop(), is_json);
  }
  if (!run.parse()) return 0;
  return answer_plan(run, file, {.wanted = PlanRequest::Wanted::Items, .items = items});
}

int cmd_join(CommandRun& run) {
  std::filesystem::path file;
  run.line.positional("PLAN", "A file that `patinate cluster plan` has made, whose items are finished", file);
  run.line.without({"seed", "force"});
  run.line.example("cluster join copper.json");
  if (!run.parse()) return 0;
  return answer_plan(run, file, {.wanted = PlanRequest::Wanted::Join});
}

}  // namespace patinate::cli
