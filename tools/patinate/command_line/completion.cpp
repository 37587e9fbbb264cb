#include "tools/patinate/command_line/completion.h"

#include "patinate/core/error.h"

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

// ---- bash: one function; the word before says whether a value is wanted, and which.

std::string bash_values(const CommandDeclaration& command) {
  std::string text;
  for (const ArgumentInfo& a : command.arguments) {
    if (a.is_positional() || a.kind == ArgumentKind::Flag) continue;
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
  std::string verbs, values, options;
  for (const CommandDeclaration& command : commands) {
    verbs += command.verb + " ";
    values += bash_values(command);
    std::vector<std::string> names{"--help"};
    for (const ArgumentInfo& a : command.arguments) {
      if (!a.is_positional()) names.push_back(names_of(a).back());
    }
    const ArgumentInfo* first = first_positional(command);
    const bool has_words = first != nullptr && !first->choices.empty();
    options += "        " + command.verb + ") if [[ $cur == -* ]]; then words=\"" + words_in_a_row(names) +
               "\"; else " + (has_words ? "words=\"" + words_in_a_row(first->choices) + "\"" : "files=1") + "; fi ;;\n";
  }
  return "# bash completion of patinate, made by `patinate completion bash`\n"
         "_patinate() {\n"
         "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} words=\"\" files=\"\"\n"
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
         "  case \"${COMP_WORDS[1]} $prev\" in\n" +
         values +
         "    *)\n"
         "      case \"${COMP_WORDS[1]}\" in\n" +
         options +
         "      esac ;;\n"
         "  esac\n"
         "  if [[ -n $files ]]; then\n"
         "    compopt -o filenames 2>/dev/null\n"
         "    mapfile -t COMPREPLY < <(compgen -f -- \"$cur\")\n"
         "  elif [[ -n $words ]]; then\n"
         "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$cur\")\n"
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
  std::string list, cases;
  for (const CommandDeclaration& command : commands) {
    list += "    " + zsh_quoted(command.verb + ":" + zsh_escaped(command.brief)) + "\n";
    cases += "    " + command.verb + ") _arguments '--help[Says what the command does]'";
    int number = 0;
    for (const ArgumentInfo& a : command.arguments) {
      if (a.kind == ArgumentKind::Positional) {
        cases +=
            " \\\n        " + zsh_quoted(std::to_string(++number) + ":" + zsh_escaped(a.name) + ":" + zsh_action(a));
      } else if (a.kind == ArgumentKind::PositionalList) {
        cases += " \\\n        " + zsh_quoted("*:" + zsh_escaped(a.name) + ":" + zsh_action(a));
      } else {
        cases += zsh_spec(a);
      }
    }
    cases += " ;;\n";
  }
  return "#compdef patinate\n"
         "# zsh completion of patinate, made by `patinate completion zsh`\n"
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
      "# fish completion of patinate, made by `patinate completion fish`\n"
      "function __patinate_verb\n"
      "  set -l words (commandline -opc)\n"
      "  test (count $words) -gt 1; and test $words[2] = $argv[1]\n"
      "end\n"
      "complete -c patinate -f\n";
  for (const CommandDeclaration& command : commands) {
    text += "complete -c patinate -n '__fish_use_subcommand' -a " + command.verb + " -d " + fish_quoted(command.brief) +
            "\n";
    text +=
        "complete -c patinate -n '__patinate_verb " + command.verb + "' -s h -l help -d 'Says what the command does'\n";
    for (const ArgumentInfo& a : command.arguments) text += fish_line(command, a);
  }
  return text;
}

}  // namespace

const std::vector<std::string>& completion_shells() {
  static const std::vector<std::string> shells{"bash", "zsh", "fish"};
  return shells;
}

std::string completion_script(const std::string& shell, std::span<const CommandDeclaration> commands) {
  if (shell == "bash") return bash_script(commands);
  if (shell == "zsh") return zsh_script(commands);
  if (shell == "fish") return fish_script(commands);
  throw InvalidInput("completion: there is none for `" + shell + "`");
}

}  // namespace patinate::cli
