#include "tools/patinate/command_line/completion.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

int cmd_completion(CommandRun& run) {
  std::string shell;
  run.line.positional("SHELL", "bash, zsh or fish", shell);
  run.line.choices(completion_shells());
  run.line.without({"threads", "seed", "json", "quiet", "verbose", "force", "dry_run", "config"});
  run.line.example("help completion bash > ~/.local/share/bash-completion/completions/patinate");
  run.line.example("help completion zsh > ~/.zfunc/_patinate");
  run.line.example("help completion fish > ~/.config/fish/completions/patinate.fish");
  if (!run.parse()) return 0;
  run.print(completion_script(shell, all_declarations()));
  return 0;
}

}  // namespace patinate::cli
