#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/manual.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

int cmd_help(CommandRun& run) {
  std::string command;
  bool man = false, markdown = false;
  std::vector<std::string> names;
  for (const Verb& verb : verbs()) names.emplace_back(verb.name);
  run.line.positional("COMMAND", "What to say more about", command);
  run.line.choices(names);
  run.line.required(false);
  run.line.flag("man", "The manual as a man page: `patinate help --man | man -l -`", man);
  run.line.flag("markdown", "The list of commands of docs/commands.md", markdown);
  run.line.without({"threads", "seed", "json", "quiet", "verbose", "force", "dry_run", "config"});
  run.line.example("help lookup");
  if (!run.parse()) return 0;
  if (man) {
    run.print(manual_roff(all_declarations(), PATINATE_VERSION));
  } else if (markdown) {
    run.print(manual_markdown(all_declarations()));
  } else if (command.empty()) {
    run.print(overview());
  } else {
    for (const Verb& verb : verbs()) {
      if (command == verb.name) run.print(help_text(declaration_of(verb)));
    }
  }
  return 0;
}

}  // namespace patinate::cli
