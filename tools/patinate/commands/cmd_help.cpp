#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/manual.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

int cmd_help(CommandRun& run) {
  std::string command, part;
  bool man = false, markdown = false;
  run.line.positional("COMMAND", "What to say more about", command);
  run.line.suggestions(first_words());
  run.line.required(false);
  run.line.positional("PART", "Its second word, as in `help fit field`", part);
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
    std::vector<std::string> words = split(command, ' ');
    if (!part.empty()) words.push_back(part);
    const std::optional<FoundVerb> found = find_verb(words);
    const bool is_found = found && found->num_words == words.size();
    if (!is_found && (words.size() > 1 || parts_of(command).empty())) fail_no_verb(words);
    run.print(is_found ? help_text(declaration_of(*found->verb)) : overview_of(command));
  }
  return 0;
}

}  // namespace patinate::cli
