#include "tools/patinate/commands/studio_commands.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "patinate/controls/control_kinds.h"
#include "tools/patinate/command_line/verbs.h"

namespace patinate::cli {

namespace {

const std::vector<std::string> kAged{"transfer", "simulation", "history"};

/// Options that concern the machine, or the whole of a run, and no result.
constexpr std::array<std::string_view, 4> kLeftOut{"output", "device", "cache", "estimate"};

std::vector<studio::JobCommand> listed_commands() {
  const auto command = [](std::string name, std::string title, std::string ending,
                          std::vector<studio::JobInput> inputs) {
    return studio::JobCommand{.name = std::move(name),
                              .title = std::move(title),
                              .brief = {},
                              .ending = std::move(ending),
                              .inputs = std::move(inputs),
                              .arguments = {}};
  };
  std::vector<studio::JobCommand> all{
      command("init", "Begin with photographs", "/capture.json", {{{"photographs"}}}),
      command("ingest", "Ingest", "_history", {{{"ingest"}, "Ingest"}}),
      command("transfer", "Transfer", "_aged",
              {{{"history", "simulation"}, "Transfer onto ...", true}, {{"mesh"}, "New transfer"}}),
      command("render", "Render", ".png", {{kAged, "Render"}}),
      command("export", "Export", ".glb", {{kAged, "Export"}}),
      command("history compare", "Compare", "_compared", {{kAged, "Compare with ...", true}, {kAged, "", true}}),
      command("evaluate", "Evaluate", "_evaluated", {{{"transfer"}, "Evaluate"}}),
      command("grade", "Grade", "_graded", {{{"history", "transfer"}, "Grade", true}}),
      command("simulate", "Simulate", "_simulated", {{{"scene"}, "Simulate"}}),
      command("fit", "Fit", "_fit", {{{"scene"}, "Fit to a history"}, {{"history", "transfer"}, "", true}})};
  for (studio::JobCommand& each : all) {
    if (each.name == "transfer") each.values = {{"control", "accessibility"}};
  }
  return all;
}

bool is_for_browsers(const ArgumentInfo& argument) {
  if (argument.is_common) return argument.key() == "seed";
  return !argument.is_written && !argument.is_moved &&
         std::find(kLeftOut.begin(), kLeftOut.end(), argument.key()) == kLeftOut.end();
}

}  // namespace

std::vector<studio::JobCommand> studio_commands() {
  std::vector<studio::JobCommand> all = listed_commands();
  for (studio::JobCommand& command : all) {
    const CommandDeclaration declaration = declaration_of(*find_verb(std::array{command.name})->verb);
    command.brief = declaration.brief;
    std::copy_if(declaration.arguments.begin(), declaration.arguments.end(), std::back_inserter(command.arguments),
                 is_for_browsers);
    for (ArgumentInfo& argument : command.arguments) {
      if (argument.key() == "control" && argument.choices.empty()) argument.choices = control_kind_names();
    }
  }
  return all;
}

void check_studio_command(const std::string& name, const std::vector<std::string>& arguments) {
  const Verb& verb = *find_verb(std::array{name})->verb;
  CommandRun run(verb.name, verb.brief, arguments, {});
  run.only_check();
  (void)verb.run(run);
}

}  // namespace patinate::cli
