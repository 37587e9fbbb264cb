#include "tools/patinate/command_line/argument.h"

#include <algorithm>

#include "libcommon/core/text.h"

namespace patinate::cli {

namespace {

constexpr std::size_t kHelpWidth = 110;

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width) {
  std::string result;
  std::size_t column = indent;
  for (const std::string& word : split(text, ' ')) {
    if (column + word.size() + 1 > width && column > indent) {
      result += "\n" + std::string(indent, ' ');
      column = indent;
    }
    result += (column > indent ? " " : "") + word;
    column += word.size() + 1;
  }
  return result;
}

}  // namespace

std::string ArgumentInfo::key() const {
  if (name == "-o") return "output";
  std::string text = name.starts_with("--") ? name.substr(2) : name;
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}

std::string ArgumentInfo::form() const {
  if (has_no_form) return "--no-" + name.substr(2);
  return name + (value_name.empty() ? "" : " " + value_name);
}

std::string ArgumentInfo::description() const {
  std::string text = (has_no_form ? "Turn off: " : "") + help;
  if (!default_text.empty()) text += "; default " + default_text;
  if (kind == ArgumentKind::Repeated) text += takes_words ? " (one or more)" : " (may be repeated)";
  if (!alias.empty()) text += " (also " + alias + ")";
  return text;
}

std::string usage_text(const CommandDeclaration& command) {
  std::string text = "patinate " + command.verb;
  bool has_options = false;
  for (const ArgumentInfo& argument : command.arguments) {
    const bool is_shown = argument.is_positional() || argument.is_required;
    has_options = has_options || !is_shown;
    if (!is_shown) continue;
    const std::string form = argument.form() + (argument.kind == ArgumentKind::PositionalList ? "..." : "");
    text += argument.is_required ? " " + form : " [" + form + "]";
  }
  return text + (has_options ? " [options]" : "");
}

namespace {

/// A name and what it means, in two columns.
std::string help_row(const std::string& name, const std::string& meaning) {
  constexpr std::size_t kIndent = 30;
  std::string left = "  " + name;
  if (left.size() + 2 > kIndent) {
    left += "\n" + std::string(kIndent, ' ');
  } else {
    left.resize(kIndent, ' ');
  }
  return left + wrapped(meaning, kIndent, kHelpWidth) + "\n";
}

bool is_own_option(const ArgumentInfo& a) { return !a.is_positional() && !a.is_common && !a.is_moved; }

/// "  patinate transfer ..." a line each, under a title.
std::string examples_text(const CommandDeclaration& command) {
  std::string text = command.examples.empty() ? "" : "\nExamples:\n";
  for (const std::string& example : command.examples) text += "  patinate " + example + "\n";
  return text;
}

std::string lists_text(const CommandDeclaration& command, bool is_all) {
  std::string text;
  for (const HelpList& list : command.lists) {
    if (list.is_long && !is_all) {
      text += "\n" + list.title + ": patinate " + command.verb + " --help-all\n";
      continue;
    }
    text += "\n" + list.title + ":\n";
    for (const auto& [name, meaning] : list.rows) text += help_row(name, meaning);
  }
  return text;
}

/// Text on what --help leaves out.
std::string rest_text(const CommandDeclaration& command, std::size_t num_left_out) {
  std::string common;
  for (const ArgumentInfo& a : command.arguments) {
    if (a.is_common) common += (common.empty() ? "" : ", ") + a.name;
  }
  return wrapped(std::to_string(num_left_out) + " more options, and what every command takes (" + common +
                     "): patinate " + command.verb + " --help-all",
                 0, kHelpWidth) +
         "\n";
}

}  // namespace

std::string help_text(const CommandDeclaration& command, bool is_all) {
  const auto num_own =
      static_cast<std::size_t>(std::count_if(command.arguments.begin(), command.arguments.end(), is_own_option));
  const bool has_usual =
      std::any_of(command.arguments.begin(), command.arguments.end(), [](const auto& a) { return a.is_usual; });
  const bool is_short = !is_all && has_usual && num_own > kMaxOptionsOfHelp;
  std::string positionals, own, common;
  std::size_t num_left_out = 0;
  for (const ArgumentInfo& argument : command.arguments) {
    if (argument.is_moved) continue;
    if (is_short && is_own_option(argument) && !argument.is_usual && !argument.is_required) {
      ++num_left_out;
      continue;
    }
    std::string& part = argument.is_positional() ? positionals : argument.is_common ? common : own;
    part += help_row(argument.form(), argument.description());
  }
  std::string text = command.brief + "\n\nUsage: " + usage_text(command) + "\n";
  if (is_short) text += examples_text(command);
  if (!positionals.empty()) text += "\n" + positionals;
  if (!own.empty()) text += "\nOptions:\n" + own;
  if (is_short) return text + "\n" + rest_text(command, num_left_out) + lists_text(command, is_all);
  text += lists_text(command, is_all);
  if (!common.empty()) text += "\nEvery command:\n" + common;
  return text + examples_text(command);
}

}  // namespace patinate::cli
