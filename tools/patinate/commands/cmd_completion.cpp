#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/argument.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

std::string words_in_a_row(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::vector<std::string> names_of(const ArgumentInfo& a) {
  if (a.name == "-o") return {"-o", "--output"};
  std::vector<std::string> names{a.has_no_form ? "--no-" + a.name.substr(2) : a.name};
  if (!a.alias.empty()) names.push_back(a.alias);
  return names;
}

const ArgumentInfo* first_positional(const CommandDeclaration& command) {
  for (const ArgumentInfo& a : command.arguments) {
    if (a.is_positional()) return &a;
  }
  return nullptr;
}

/// Commands of two words: "fit field".
std::vector<std::string> pairs_in(std::span<const CommandDeclaration> commands) {
  std::vector<std::string> pairs;
  for (const CommandDeclaration& command : commands) {
    if (command.verb.find(' ') != std::string::npos) pairs.push_back(command.verb);
  }
  return pairs;
}

/// First words, each once, and the second words that may stand behind them.
std::vector<std::pair<std::string, std::vector<std::string>>> verbs_in(std::span<const CommandDeclaration> commands) {
  std::vector<std::pair<std::string, std::vector<std::string>>> verbs;
  for (const CommandDeclaration& command : commands) {
    const std::vector<std::string> words = split(command.verb, ' ');
    auto verb = std::find_if(verbs.begin(), verbs.end(), [&](const auto& v) { return v.first == words[0]; });
    if (verb == verbs.end()) verb = verbs.insert(verbs.end(), {words[0], {}});
    if (words.size() > 1) verb->second.push_back(words[1]);
  }
  return verbs;
}

/// Text on a first word, for lists: the brief of its command, or what may stand behind it.
std::string verb_text(std::span<const CommandDeclaration> commands, const std::string& word,
                      const std::vector<std::string>& parts) {
  for (const CommandDeclaration& command : commands) {
    if (command.verb == word) return command.brief;
  }
  return words_in_a_row(parts);
}

/// `"fit field"|"fit rank"`, a pattern of bash and zsh.
std::string pairs_pattern(std::span<const CommandDeclaration> commands) {
  std::string text;
  for (const std::string& pair : pairs_in(commands)) text += (text.empty() ? "\"" : "|\"") + pair + "\"";
  return text;
}

// ---- bash: one function; the word before says whether a value is wanted, and which.

std::string bash_values(const CommandDeclaration& command) {
  std::string text;
  for (const ArgumentInfo& a : command.arguments) {
    if (a.is_positional() || a.is_moved || a.kind == ArgumentKind::Flag) continue;
    std::string pattern;
    for (const std::string& name : names_of(a))
      pattern += (pattern.empty() ? "\"" : "|\"") + command.verb + " " + name + "\"";
    text += "    " + pattern + ") ";
    text += !a.choices.empty()          ? "words=\"" + words_in_a_row(a.choices) + "\""
            : a.type == ValueType::Path ? "files=1"
                                        : "return 0";
    text += " ;;\n";
  }
  return text;
}

std::string bash_script(std::span<const CommandDeclaration> commands) {
  std::string verbs, values, options, parts;
  for (const auto& [verb, seconds] : verbs_in(commands)) {
    verbs += verb + " ";
    if (!seconds.empty()) parts += "      " + verb + ") parts=\"" + words_in_a_row(seconds) + "\" ;;\n";
  }
  for (const CommandDeclaration& command : commands) {
    values += bash_values(command);
    std::vector<std::string> names{"--help", "--help-all"};
    for (const ArgumentInfo& a : command.arguments) {
      if (!a.is_positional() && !a.is_moved) names.push_back(names_of(a).back());
    }
    const ArgumentInfo* first = first_positional(command);
    const bool has_words = first != nullptr && !first->choices.empty();
    options += "        \"" + command.verb + "\") if [[ $cur == -* ]]; then words=\"" + words_in_a_row(names) +
               "\"; else " + (has_words ? "words=\"" + words_in_a_row(first->choices) + "\"" : "files=1") + "; fi ;;\n";
  }
  return "# bash completion of patinate, made by `patinate help completion bash`\n"
         "_patinate() {\n"
         "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} verb=${COMP_WORDS[1]} parts=\"\" "
         "words=\"\" files=\"\"\n"
         "  COMPREPLY=()\n"
         "  if ((COMP_CWORD == 1)); then\n"
         "    mapfile -t COMPREPLY < <(compgen -W \"" +
         verbs +
         "--help --version\" -- \"$cur\")\n"
         "    return 0\n"
         "  fi\n"
         "  if [[ $cur == \"=\" ]]; then cur=\"\"\n"
         "  elif [[ $prev == \"=\" ]]; then prev=${COMP_WORDS[COMP_CWORD-2]}\n"
         "  fi\n"
         "  if ((COMP_CWORD == 2)) && [[ $cur != -* ]]; then\n"
         "    case \"$verb\" in\n" +
         parts +
         "    esac\n"
         "  elif ((COMP_CWORD > 2)); then\n"
         "    case \"$verb ${COMP_WORDS[2]}\" in\n"
         "      " +
         pairs_pattern(commands) +
         ") verb=\"$verb ${COMP_WORDS[2]}\" ;;\n"
         "    esac\n"
         "  fi\n"
         "  case \"$verb $prev\" in\n" +
         values +
         "    *)\n"
         "      case \"$verb\" in\n" +
         options +
         "      esac ;;\n"
         "  esac\n"
         "  words=\"$parts $words\"\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$cur\")\n"
         "  if [[ -n $files ]]; then\n"
         "    compopt -o filenames 2>/dev/null\n"
         "    mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- \"$cur\")\n"
         "  fi\n"
         "}\n"
         "complete -F _patinate patinate\n";
}

// ---- zsh: _arguments specs.

std::string zsh_quoted(const std::string& text) { return "'" + replaced(text, "'", "'\\''") + "'"; }

std::string zsh_escaped(std::string text) {
  for (const char* special : {"\\", "[", "]", ":"})
    text = replaced(std::move(text), special, std::string("\\") + special);
  return text;
}

std::string zsh_action(const ArgumentInfo& a) {
  if (!a.choices.empty()) {
    return "(" + replaced(replaced(words_in_a_row(a.choices), "(", "\\("), ")", "\\)") + ")";
  }
  return a.type == ValueType::Path ? "_files" : " ";
}

std::string zsh_spec(const ArgumentInfo& a) {
  const std::string help = "[" + zsh_escaped(a.description()) + "]";
  const std::string value = a.kind == ArgumentKind::Flag ? "" : ":" + zsh_escaped(a.value_name) + ":" + zsh_action(a);
  std::string text;
  for (const std::string& name : names_of(a)) {
    text += " \\\n        " + zsh_quoted((a.kind == ArgumentKind::Repeated ? "*" : "") + name + help + value);
  }
  return text;
}

std::string zsh_script(std::span<const CommandDeclaration> commands) {
  std::string list, cases, parts;
  for (const auto& [verb, seconds] : verbs_in(commands)) {
    list += "    " + zsh_quoted(verb + ":" + zsh_escaped(verb_text(commands, verb, seconds))) + "\n";
    if (!seconds.empty()) parts += "      " + verb + ") compadd " + words_in_a_row(seconds) + " ;;\n";
  }
  for (const CommandDeclaration& command : commands) {
    cases += "    \"" + command.verb +
             "\") _arguments '--help[Says what the command does]' '--help-all[Says all of its options]'";
    int number = 0;
    for (const ArgumentInfo& a : command.arguments) {
      if (a.kind == ArgumentKind::Positional) {
        cases +=
            " \\\n        " + zsh_quoted(std::to_string(++number) + ":" + zsh_escaped(a.name) + ":" + zsh_action(a));
      } else if (a.kind == ArgumentKind::PositionalList) {
        cases += " \\\n        " + zsh_quoted("*:" + zsh_escaped(a.name) + ":" + zsh_action(a));
      } else if (!a.is_moved) {
        cases += zsh_spec(a);
      }
    }
    cases += " ;;\n";
  }
  return "#compdef patinate\n"
         "# zsh completion of patinate, made by `patinate help completion zsh`\n"
         "_patinate() {\n"
         "  local -a commands\n"
         "  commands=(\n" +
         list +
         "  )\n"
         "  if (( CURRENT == 2 )); then\n"
         "    _describe command commands\n"
         "    return\n"
         "  fi\n"
         "  local verb=$words[2]\n"
         "  if (( CURRENT == 3 )) && [[ $words[3] != -* ]]; then\n"
         "    case $verb in\n" +
         parts +
         "    esac\n"
         "  elif (( CURRENT > 3 )); then\n"
         "    case \"$verb $words[3]\" in\n"
         "      " +
         pairs_pattern(commands) +
         ") verb=\"$verb $words[3]\"; shift words; (( CURRENT-- )) ;;\n"
         "    esac\n"
         "  fi\n"
         "  shift words\n"
         "  (( CURRENT-- ))\n"
         "  case $verb in\n" +
         cases +
         "  esac\n"
         "}\n"
         "if [[ $funcstack[1] == _patinate ]]; then _patinate \"$@\"; else compdef _patinate patinate; fi\n";
}

// ---- fish: one `complete` line for each option.

std::string fish_quoted(const std::string& text) {
  return "'" + replaced(replaced(text, "\\", "\\\\"), "'", "\\'") + "'";
}

std::string fish_line(const CommandDeclaration& command, const ArgumentInfo& a) {
  std::string text = "complete -c patinate -n '__patinate_verb " + command.verb + "'";
  if (!a.is_positional()) {
    for (const std::string& name : names_of(a))
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (!a.choices.empty()) {
    text += (a.is_positional() ? " -a " : " -x -a ") + fish_quoted(words_in_a_row(a.choices));
  } else if (a.type == ValueType::Path) {
    text += a.is_positional() ? " -F" : " -r -F";
  } else if (a.kind != ArgumentKind::Flag && !a.is_positional()) {
    text += " -x";
  }
  return text + " -d " + fish_quoted(a.description()) + "\n";
}

std::string fish_script(std::span<const CommandDeclaration> commands) {
  std::string text =
      "# fish completion of patinate, made by `patinate help completion fish`\n"
      "function __patinate_verb\n"
      "  set -l words (commandline -opc)\n"
      "  test (count $words) -gt 1; or return 1\n"
      "  set -l verb $words[2]\n"
      "  if test (count $words) -gt 2; and contains -- \"$words[2] $words[3]\"";
  for (const std::string& pair : pairs_in(commands)) text += " '" + pair + "'";
  text +=
      "\n"
      "    set verb \"$words[2] $words[3]\"\n"
      "  end\n"
      "  test \"$verb\" = \"$argv\"\n"
      "end\n"
      "function __patinate_first\n"
      "  __patinate_verb $argv; and test (count (commandline -opc)) -eq 2\n"
      "end\n"
      "complete -c patinate -f\n";
  for (const auto& [verb, seconds] : verbs_in(commands)) {
    text += "complete -c patinate -n '__fish_use_subcommand' -a " + verb + " -d " +
            fish_quoted(verb_text(commands, verb, seconds)) + "\n";
    if (!seconds.empty())
      text += "complete -c patinate -n '__patinate_first " + verb + "' -a '" + words_in_a_row(seconds) + "'\n";
  }
  for (const CommandDeclaration& command : commands) {
    text +=
        "complete -c patinate -n '__patinate_verb " + command.verb + "' -s h -l help -d 'Says what the command does'\n";
    text += "complete -c patinate -n '__patinate_verb " + command.verb + "' -l help-all -d 'Says all of its options'\n";
    for (const ArgumentInfo& a : command.arguments) {
      if (!a.is_moved) text += fish_line(command, a);
    }
  }
  return text;
}

const std::vector<std::string>& completion_shells() {
  static const std::vector<std::string> shells{"bash", "zsh", "fish"};
  return shells;
}

/// A script that a shell sources: commands, options, their choices, and files where a path is wanted.
/// @param shell  One of completion_shells(). @throws InvalidInput if it is none.
std::string completion_script(const std::string& shell, std::span<const CommandDeclaration> commands) {
  if (shell == "bash") return bash_script(commands);
  if (shell == "zsh") return zsh_script(commands);
  if (shell == "fish") return fish_script(commands);
  throw InvalidInput("completion: there is none for `" + shell + "`");
}

}  // namespace

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
