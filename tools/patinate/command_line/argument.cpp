#include "tools/patinate/command_line/argument.h"

#include <algorithm>

#include "libcommon/core/text.h"

namespace patinate::cli {

namespace {

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
  std::string text = (has_no_form ? "Without: " : "") + help;
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
  constexpr std::size_t kIndent = 30, kWidth = 110;
  std::string left = "  " + name;
  if (left.size() + 2 > kIndent) {
    left += "\n" + std::string(kIndent, ' ');
  } else {
    left.resize(kIndent, ' ');
  }
  return left + wrapped(meaning, kIndent, kWidth) + "\n";
}

}  // namespace

std::string help_text(const CommandDeclaration& command) {
  std::string positionals, own, common;
  for (const ArgumentInfo& argument : command.arguments) {
    std::string& part = argument.is_positional() ? positionals : argument.is_common ? common : own;
    part += help_row(argument.form(), argument.description());
  }
  std::string text = command.brief + "\n\nUsage: " + usage_text(command) + "\n";
  if (!positionals.empty()) text += "\n" + positionals;
  if (!own.empty()) text += "\nOptions:\n" + own;
  for (const HelpList& list : command.lists) {
    text += "\n" + list.title + ":\n";
    for (const auto& [name, meaning] : list.rows) text += help_row(name, meaning);
  }
  if (!common.empty()) text += "\nEvery command:\n" + common;
  if (!command.examples.empty()) text += "\nExamples:\n";
  for (const std::string& example : command.examples) text += "  patinate " + example + "\n";
  return text;
}

}  // namespace patinate::cli
