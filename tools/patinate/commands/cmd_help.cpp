#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/argument.h"
#include "tools/patinate/command_line/verbs.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/info/document_schemas.h"

namespace patinate::cli {

namespace {

/// The options of every command; a command that has all of them gives the list.
std::vector<ArgumentInfo> common_options(std::span<const CommandDeclaration> commands) {
  std::vector<ArgumentInfo> most;
  for (const CommandDeclaration& command : commands) {
    std::vector<ArgumentInfo> common;
    std::copy_if(command.arguments.begin(), command.arguments.end(), std::back_inserter(common),
                 [](const auto& a) { return a.is_common; });
    if (common.size() > most.size()) most = std::move(common);
  }
  return most;
}

/// Text in which roff sees no command.
std::string roff(const std::string& text) {
  std::string result;
  for (char c : text) {
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n')) {
      result += "\\&" + std::string(1, c);
    } else {
      result += c;
    }
  }
  return result;
}

std::string roff_argument(const ArgumentInfo& a) {
  return ".TP\n.B " + roff(a.form()) + "\n" + roff(a.description()) + "\n";
}

constexpr const char* kRoffEnd =
    ".SH CONFIGURATION\n"
    "Options come from the command line, else from variables of the environment, else from the file of\n"
    ".BR \\-\\-config ,\n"
    "else they have their default.\n"
    ".B PATINATE_SPATIAL_SIGMA\n"
    "is\n"
    ".BR \\-\\-spatial\\-sigma .\n"
    "A file is TOML: options of every command at the top, others in a section of their command.\n"
    ".PP\n.nf\n"
    "threads = 4\n"
    "\n"
    "[transfer]\n"
    "coherence = 0.9\n"
    "control = [\"thickness=facing\"]\n"
    ".fi\n"
    ".SH EXIT STATUS\n"
    ".TP\n.B 0\nDone, or up to date.\n"
    ".TP\n.B 1\nIt could not be done: the disk is full, a different output is there.\n"
    ".TP\n.B 2\nThe command line is wrong.\n"
    ".TP\n.B 3\nThe input is wrong.\n"
    ".TP\n.B 130\nInterrupted.\n";

std::string markdown_cell(const std::string& text) {
  std::string result;
  for (char c : text) {
    if (c == '|' || c == '<' || c == '*' || c == '_') result += '\\';
    result += c;
  }
  return result;
}

std::string markdown_code(const std::string& text) {
  std::string result;
  for (char c : text) result += c == '|' ? "\\|" : std::string(1, c);
  return "`" + result + "`";
}

std::string markdown_row(const ArgumentInfo& a) {
  return "| " + markdown_code(a.form()) + " | " + markdown_cell(a.description()) + " |\n";
}

/// patinate.1 in roff, with the macros of man(7). @param version  "0.1.0".
std::string manual_roff(std::span<const CommandDeclaration> commands, const std::string& version) {
  std::string text = ".TH PATINATE 1 \"\" \"patinate " + version +
                     "\" \"User Commands\"\n"
                     ".SH NAME\npatinate \\- capture how materials age, and let meshes age like them\n"
                     ".SH SYNOPSIS\n.B patinate\n.I COMMAND\n[arguments]\n"
                     ".SH DESCRIPTION\n"
                     "Makes a material history of time\\-lapse photographs, ages a mesh with it according to a "
                     "parameter of its surface, and shows\n"
                     "the result at any time. Outputs are whole or absent; an interrupted command resumes where it was "
                     "when it is given again.\n"
                     ".SH COMMANDS\n";
  for (const CommandDeclaration& command : commands) {
    text += ".SS " + roff(command.verb) + "\n.B " + roff(usage_text(command)) + "\n.PP\n" + roff(command.brief) + "\n";
    for (const ArgumentInfo& a : command.arguments) {
      if (!a.is_common && !a.is_moved) text += roff_argument(a);
    }
    for (const HelpList& list : command.lists) {
      text += ".PP\n" + roff(list.title) + ":\n";
      for (const auto& [name, meaning] : list.rows) text += ".TP\n.B " + roff(name) + "\n" + roff(meaning) + "\n";
    }
    if (!command.examples.empty()) text += ".PP\n.nf\n";
    for (const std::string& example : command.examples) text += roff("patinate " + example) + "\n";
    if (!command.examples.empty()) text += ".fi\n";
  }
  text += ".SH OPTIONS OF EVERY COMMAND\n";
  for (const ArgumentInfo& a : common_options(commands)) text += roff_argument(a);
  return text + kRoffEnd;
}

/// The part of docs/commands.md that lists every command with its options.
std::string manual_markdown(std::span<const CommandDeclaration> commands) {
  std::string text = "## Options of every command\n\n| option | meaning |\n| --- | --- |\n";
  for (const ArgumentInfo& a : common_options(commands)) text += markdown_row(a);
  for (const CommandDeclaration& command : commands) {
    text += "\n## " + command.verb + "\n" + command.brief + "\n\n    " + usage_text(command) + "\n";
    for (const std::string& example : command.examples) text += "    patinate " + example + "\n";
    const bool has_own = std::any_of(command.arguments.begin(), command.arguments.end(),
                                     [](const auto& a) { return !a.is_common && !a.is_moved; });
    if (has_own) text += "\n| argument | meaning |\n| --- | --- |\n";
    for (const ArgumentInfo& a : command.arguments) {
      if (!a.is_common && !a.is_moved) text += markdown_row(a);
    }
    for (const HelpList& list : command.lists) {
      text += "\n" + list.title + ":\n\n| name | meaning |\n| --- | --- |\n";
      for (const auto& [name, meaning] : list.rows)
        text += "| " + markdown_code(name) + " | " + markdown_cell(meaning) + " |\n";
    }
  }
  return text;
}

}  // namespace

int cmd_help(CommandRun& run) {
  std::string command, part, schema;
  bool man = false, markdown = false;
  run.line.positional("COMMAND", "What to say more about", command);
  run.line.suggestions(first_words());
  run.line.required(false);
  run.line.positional("PART", "Its second word, as in `help fit field`", part);
  run.line.required(false);
  run.line.flag("man", "The manual as a man page: `patinate help --man | man -l -`", man);
  run.line.flag("markdown", "The list of commands of docs/commands.md", markdown);
  run.line.option("schema", "KIND", "The JSON Schema of a kind of file that patinate writes", schema);
  run.line.suggestions(schema_names());
  run.line.without({"threads", "seed", "json", "quiet", "verbose", "force", "dry_run", "config"});
  run.line.example("help texture");
  if (!run.parse()) return 0;
  if (man) {
    run.print(manual_roff(all_declarations(), PATINATE_VERSION));
  } else if (markdown) {
    run.print(manual_markdown(all_declarations()));
  } else if (!schema.empty()) {
    run.print(schema_of(schema).dump(2) + "\n");
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
