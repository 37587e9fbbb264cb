#include "tools/patinate/command_line/option_sources.h"

#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>

#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::cli {

namespace {

constexpr std::string_view kEnvironmentPrefix = "PATINATE_";
/// Variables that begin so and are no options: of tests, of decoder_process.h, history_library.h, module.h and
/// studio_job.h.
constexpr std::array<std::string_view, 7> kOtherVariables{"DATA",    "DECODER", "DECODER_SECONDS", "LIBRARY",
                                                          "MODULES", "OPENCL",  "STUDIO_JOB"};

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// The option of a command by its key or the key of its alias.
const ArgumentInfo* option_of(const CommandDeclaration& command, const std::string& key) {
  for (const ArgumentInfo& a : command.arguments) {
    if (!a.is_positional() && (a.key() == key || (!a.alias.empty() && a.alias == dashed(key)))) return &a;
  }
  return nullptr;
}

const ArgumentInfo* option_of_any(std::span<const CommandDeclaration> commands, const std::string& key) {
  for (const CommandDeclaration& command : commands) {
    if (const ArgumentInfo* option = option_of(command, key)) return option;
  }
  return nullptr;
}

/// Where a configuration file has the options of a command: "fit.field".
std::string section_name(std::string verb) {
  std::replace(verb.begin(), verb.end(), ' ', '.');
  return verb;
}

/// "true" or "false".
std::string flag_text(const std::string& name, const std::string& value) {
  const std::string word = lower_case(value);
  for (const char* yes : {"true", "1", "yes", "on"}) {
    if (word == yes) return "true";
  }
  for (const char* no : {"false", "0", "no", "off"}) {
    if (word == no) return "false";
  }
  throw app::UsageError(name + ": found `" + value + "`; expected true or false");
}

/// Tells characters that end a run of parts of a key.
bool ends_key(char c) { return std::string_view("\n=,[]{}").find(c) != std::string_view::npos; }

/// Behind the string that begins at `at`: three quotes end one of several lines, a backslash escapes in `"` but not in
/// `'`.
std::size_t behind_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string three(3, quote);
  const bool is_long = text.substr(at, 3) == three;
  for (at += is_long ? 3 : 1; at < text.size(); ++at) {
    if (quote == '"' && text[at] == '\\')
      ++at;
    else if (is_long ? text.substr(at, 3) == three : text[at] == quote || text[at] == '\n')
      return at + (is_long ? 3 : 1);
  }
  return text.size();
}

/// The line of a key of more parts than any of ours, 0 if there is none. Each dot is a level of tables: tens of
/// thousands, and whoever frees them recurses until the stack ends. (Brackets within brackets the parser limits
/// itself.)
std::size_t line_of_deep_key(std::string_view text) {
  constexpr int kMaxDots = 8;
  int dots = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = behind_string(text, at);
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    dots = c == '.' ? dots + 1 : ends_key(c) ? 0 : dots;
    if (dots > kMaxDots)
      return 1 +
             static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    ++at;
  }
  return 0;
}

class ConfigFile {
 public:
  ConfigFile(CommandLine& line, const std::string& verb, const std::filesystem::path& file,
             std::span<const CommandDeclaration> commands)
      : line_(line), verb_(verb), file_(file.string()), commands_(commands) {}

  void read() {
    app::require_exists(file_);
    constexpr std::uint64_t kMaxBytes = 1 << 20;
    const std::string text = read_file(file_, kMaxBytes);
    if (const std::size_t line = line_of_deep_key(text); line > 0)
      throw IoError(file_, "line " + std::to_string(line) +
                               ": a key of so many parts is none of ours; expected NAME = VALUE below [COMMAND]");
    try {
      table_ = toml::parse(text, file_);
    } catch (const toml::parse_error& e) {
      throw IoError(file_, "line " + std::to_string(e.source().begin.line) + ": " + std::string(e.description()));
    }
    for (const auto& [key, node] : table_) {
      const std::string name(key.str());
      if (const toml::table* section = node.as_table()) {
        read_section(name, *section);
      } else {
        read_common(name, node);
      }
    }
  }

 private:
  [[noreturn]] void fail(const toml::node& node, const std::string& problem) const {
    throw IoError(file_, place(node) + ": " + problem);
  }
  [[nodiscard]] static std::string place(const toml::node& node) {
    return "line " + std::to_string(node.source().begin.line);
  }

  /// [transfer]; [fit.field], which is a table in [fit]; by a former name, [field].
  void read_section(const std::string& name, const toml::table& section) {
    const auto command = std::find_if(commands_.begin(), commands_.end(), [&](const auto& c) {
      return c.verb == name || std::find(c.formers.begin(), c.formers.end(), name) != c.formers.end();
    });
    const auto below =
        std::find_if(commands_.begin(), commands_.end(), [&](const auto& c) { return c.verb.starts_with(name + " "); });
    if (command == commands_.end() && below == commands_.end()) fail_unknown(name, section);
    for (const auto& [key, node] : section) {
      const std::string word(key.str());
      if (const toml::table* inner = node.as_table(); inner != nullptr && below != commands_.end()) {
        read_section(name + " " + word, *inner);
      } else if (command == commands_.end()) {
        fail(node, section_name(name) + "." + word + ": is below no command; write it under [" +
                       section_name(below->verb) + "] or another");
      } else {
        read_option(*command, word, node);
      }
    }
  }

  [[noreturn]] void fail_unknown(const std::string& name, const toml::node& section) const {
    std::vector<std::string> names;
    for (const CommandDeclaration& c : commands_) names.insert(names.end(), {c.verb, split(c.verb, ' ').front()});
    fail(section, "[" + section_name(name) + "]: there is no such command" + did_you_mean(name, names));
  }

  void read_common(const std::string& name, const toml::node& node) {
    const std::string key = normal(name);
    std::vector<std::string> keys;
    std::string sections;
    for (const CommandDeclaration& command : commands_) {
      for (const ArgumentInfo& a : command.arguments) {
        if (a.is_common && a.key() == key) return supply(a, name, node, true);
        if (a.is_common) keys.push_back(a.key());
        if (!a.is_common && !a.is_positional() && a.key() == key)
          sections += (sections.empty() ? "[" : ", [") + section_name(command.verb) + "]";
      }
    }
    if (!sections.empty()) fail(node, name + ": is no option of every command; write it under " + sections);
    fail(node, name + ": there is no such option" + did_you_mean(key, keys));
  }

  void read_option(const CommandDeclaration& command, const std::string& name, const toml::node& node) {
    const std::string key = normal(name);
    if (const ArgumentInfo* option = option_of(command, key))
      return supply(*option, section_name(command.verb) + "." + name, node, command.verb == verb_);
    std::vector<std::string> keys;
    for (const ArgumentInfo& a : command.arguments) {
      if (!a.is_positional()) keys.push_back(a.key());
    }
    fail(node, section_name(command.verb) + "." + name + ": `" + command.verb + "` has no such option" +
                   did_you_mean(key, keys));
  }

  /// Checks the value's type; hands it over when it is meant for the command that runs.
  void supply(const ArgumentInfo& option, const std::string& name, const toml::node& node, bool is_meant) {
    std::vector<std::string> values;
    if (option.key() == "config") fail(node, name + ": a configuration file names no other");
    if (option.kind == ArgumentKind::Flag) {
      if (!node.is_boolean()) fail_type(node, name, "true or false");
      values = {node.as_boolean()->get() ? "true" : "false"};
    } else if (option.type == ValueType::Numbers) {
      values = {numbers(node, name)};
    } else if (option.kind == ArgumentKind::Repeated && node.is_array()) {
      for (const toml::node& element : *node.as_array()) values.push_back(text(option, element, name));
    } else {
      values = {text(option, node, name)};
    }
    if (is_meant) line_.supply(option.key(), values, file_ + ": " + place(node));
  }

  std::string text(const ArgumentInfo& option, const toml::node& node, const std::string& name) const {
    if (option.type == ValueType::Text || option.type == ValueType::Path) {
      if (!node.is_string())
        fail_type(node, name, option.choices.empty() ? "text in quotes" : "one of its words, in quotes");
      return node.as_string()->get();
    }
    if (option.type == ValueType::Integer && !node.is_integer()) fail_type(node, name, "an integer");
    return number(node, name);
  }

  std::string number(const toml::node& node, const std::string& name) const {
    if (node.is_integer()) return std::to_string(node.as_integer()->get());
    if (!node.is_floating_point()) fail_type(node, name, "a number");
    return number_text(node.as_floating_point()->get());
  }

  std::string numbers(const toml::node& node, const std::string& name) const {
    if (!node.is_array()) return number(node, name);
    std::string joined;
    for (const toml::node& element : *node.as_array()) joined += (joined.empty() ? "" : ",") + number(element, name);
    return joined;
  }

  [[noreturn]] void fail_type(const toml::node& node, const std::string& name, const std::string& expected) const {
    std::ostringstream found;
    found << node.type();
    fail(node, name + ": found a value of type " + found.str() + "; expected " + expected);
  }

  static std::string normal(std::string key) {
    std::replace(key.begin(), key.end(), '-', '_');
    return key;
  }

  CommandLine& line_;
  const std::string& verb_;
  std::string file_;
  std::span<const CommandDeclaration> commands_;
  toml::table table_;
};

}  // namespace

Environment patinate_environment() {
  Environment result;
  for (char** entry = ::environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::size_t equals = text.find('=');
    if (!text.starts_with(kEnvironmentPrefix) || equals == std::string_view::npos) continue;
    std::string name(text.substr(kEnvironmentPrefix.size(), equals - kEnvironmentPrefix.size()));
    if (std::find(kOtherVariables.begin(), kOtherVariables.end(), name) != kOtherVariables.end()) continue;
    result.emplace_back(std::move(name), std::string(text.substr(equals + 1)));
  }
  std::sort(result.begin(), result.end());
  return result;
}

std::vector<std::string> supply_environment(CommandLine& line, const Environment& environment,
                                            std::span<const CommandDeclaration> commands) {
  std::vector<std::string> notes, names;
  for (const CommandDeclaration& command : commands) {
    for (const ArgumentInfo& a : command.arguments) {
      if (!a.is_positional()) names.push_back(std::string(kEnvironmentPrefix) + upper(a.key()));
    }
  }
  for (const auto& [name, value] : environment) {
    const std::string variable = std::string(kEnvironmentPrefix) + name, key = lower_case(name);
    const ArgumentInfo* option = option_of_any(commands, key);
    if (option == nullptr) {
      notes.push_back(variable + ": is no option of any command and is ignored" + did_you_mean(variable, names));
    } else if (!value.empty()) {
      line.supply(key, {option->kind == ArgumentKind::Flag ? flag_text(variable, value) : value}, variable);
    }
  }
  return notes;
}

void supply_config(CommandLine& line, const std::string& verb, const std::filesystem::path& file,
                   std::span<const CommandDeclaration> commands) {
  ConfigFile(line, verb, file, commands).read();
}

}  // namespace patinate::cli
