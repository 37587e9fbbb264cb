#include "tools/studio/job_commands.h"

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>

#include "libcommon/core/file_name.h"
#include "libcommon/core/text.h"

namespace patinate::studio {

namespace fs = std::filesystem;
using cli::ArgumentInfo;
using cli::ArgumentKind;
using cli::ValueType;

namespace {

constexpr std::size_t kMaxText = 4096, kMaxValues = 64;
constexpr std::size_t kMaxProposed = 96;  ///< So that a number still fits behind it.
constexpr std::string_view kLibrary = "library:";
constexpr const char* kOutput = "output";
constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  ///< Stands in JSON for bytes that are not UTF-8.

/// What was given for one argument.
struct Given {
  const ArgumentInfo* argument;
  std::vector<std::string> values;  ///< Of a flag: "true" or "false".
};

bool is_list(const ArgumentInfo& a) {
  return a.kind == ArgumentKind::Repeated || a.kind == ArgumentKind::PositionalList;
}

std::string checked_text(const ArgumentInfo& argument, const std::string& text) {
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (text.size() > kMaxText || std::any_of(text.begin(), text.end(), is_control))
    throw WrongArgument(argument.key(), "is too long, or has more than one line");
  return text;
}

/// A name below the folder, as a word that is no option.
std::string checked_path(const ServedFolder& folder, const ArgumentInfo& argument, const std::string& name,
                         bool may_be_library) {
  if (may_be_library && name.starts_with(kLibrary) && is_file_name(name.substr(kLibrary.size()))) return name;
  if (name.find(kReplacement) != std::string::npos && !folder.find(name))
    throw WrongArgument(argument.key(),
                        "\"" + name + "\" is not UTF-8 on the disk, so no page can ask for it; rename it");
  if (name.starts_with(kLibrary) || !folder.find(name))
    throw WrongArgument(argument.key(), "there is no \"" + name + "\" in the folder that is served");
  return name.starts_with("-") ? "./" + name : name;
}

Given given_of(const ServedFolder& folder, const ArgumentInfo& argument, const JsonReader& value, bool may_be_library) {
  Given given{&argument, {}};
  if (argument.kind == ArgumentKind::Flag) {
    given.values = {value.boolean() ? "true" : "false"};
    return given;
  }
  std::vector<std::string> texts;
  if (is_list(argument)) {
    for (const JsonReader& element : value.elements(kMaxValues)) texts.push_back(element.string());
  } else {
    texts.push_back(value.string());
  }
  for (const std::string& text : texts) {
    if (checked_text(argument, text).empty()) continue;
    given.values.push_back(argument.type == ValueType::Path ? checked_path(folder, argument, text, may_be_library)
                                                            : text);
  }
  return given;
}

/// Where a path of the served folder lies; `library:NAME` as it is.
std::string absolute_word(const ServedFolder& folder, const std::string& word) {
  return word.starts_with(kLibrary) ? word : (folder.path() / word).string();
}

/// A command line, behind the command. @param is_absolute  Paths are those of this process.
std::vector<std::string> words_of(const ServedFolder& folder, const std::vector<Given>& all, const std::string& output,
                                  bool is_absolute) {
  std::vector<std::string> positionals, options;
  for (const auto& [argument, values] : all) {
    const auto word = [&](const std::string& value) {
      return is_absolute && argument->type == ValueType::Path ? absolute_word(folder, value) : value;
    };
    if (argument->is_positional()) {
      for (const std::string& value : values) positionals.push_back(word(value));
    } else if (argument->kind == ArgumentKind::Flag) {
      const bool is_on = values.front() == "true";
      if (is_on && !argument->has_no_form) options.push_back(argument->name);
      if (!is_on && argument->has_no_form) options.push_back("--no-" + argument->name.substr(2));
    } else if (argument->takes_words && !values.empty()) {
      options.push_back(argument->name);
      for (const std::string& value : values) options.push_back(word(value));
    } else {
      for (const std::string& value : values) {
        if (value.starts_with("-")) {
          options.push_back(argument->name + "=" + value);  // Else it would be an option.
        } else {
          options.insert(options.end(), {argument->name, word(value)});
        }
      }
    }
  }
  positionals.insert(positionals.end(), {"-o", is_absolute ? absolute_word(folder, output) : output});
  positionals.insert(positionals.end(), options.begin(), options.end());
  return positionals;
}

/// Whether nothing in a folder that is resumed leads elsewhere.
bool has_links(const fs::path& folder) {
  std::error_code error;
  if (fs::is_symlink(folder, error)) return true;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_symlink(error)) return true;
  }
  return false;
}

std::string checked_output(const ServedFolder& folder, const std::string& name) {
  try {
    const fs::path path = folder.new_path(name);
    if (!is_file_name(path.filename().string()))
      throw InvalidInput("\"" + path.filename().string() + "\" cannot be a name here; use " + file_name_text());
    for (const char* more : {".partial", ".items"}) {
      if (has_links(path.string() + more)) throw InvalidInput(name + more + ": is or has a link; remove it first");
    }
  } catch (const InputError& e) {
    throw WrongArgument(kOutput, e.what());
  }
  return name.starts_with("-") ? "./" + name : name;
}

/// "vase_crackle_aged": letters of the inputs' names.
std::string proposed_stem(const JobCommand& command, const std::vector<Given>& all) {
  std::string stem;
  for (const auto& [argument, values] : all) {
    if (!argument->is_positional()) continue;
    for (const std::string& value : values) {
      if (command.ending.starts_with("/")) return value;
      const std::string text = value.starts_with(kLibrary) ? value.substr(kLibrary.size()) : value;
      const fs::path path(text == "." ? "" : text);
      // Every second mesh is called so.
      const bool is_plain = path.stem() == "mesh" || path.stem() == "scene" || path.stem() == "capture";
      const bool has_folder = is_plain && path.has_parent_path();
      const fs::path name = has_folder ? path.parent_path().filename() : path.stem();
      if (!name.empty()) stem += (stem.empty() ? "" : "_") + name.string();
    }
  }
  std::replace_if(
      stem.begin(), stem.end(), [](char c) { return !is_file_name(std::string("a") + c); }, '_');
  while (stem.starts_with('.') || stem.starts_with('-')) stem.erase(0, 1);
  return stem.empty() ? "made" : stem.substr(0, kMaxProposed);
}

std::string proposed_output(const ServedFolder& folder, const JobCommand& command, const std::vector<Given>& all) {
  constexpr int kMostOfOneName = 1000;
  const std::size_t dot = std::min(command.ending.rfind('.'), command.ending.size());
  const std::string extension = command.ending.substr(dot);
  const std::string stem = proposed_stem(command, all) + command.ending.substr(0, dot);
  for (int k = 1; k <= kMostOfOneName; ++k) {
    const std::string name = stem + (k == 1 ? "" : "-" + std::to_string(k)) + extension;
    std::error_code error;
    const fs::path path = folder.path() / name;
    const auto is_taken = [&](const fs::path& p) {
      return fs::symlink_status(p, error).type() != fs::file_type::not_found;
    };
    if (!is_taken(path) && !is_taken(path.string() + ".partial")) return checked_output(folder, name);
  }
  throw WrongArgument(kOutput, "give a name");
}

/// Says at which argument the message of a command is aimed. @throws WrongArgument
[[noreturn]] void fail_argument(const ServedFolder& folder, const JobCommand& command, std::string text) {
  const std::string root = folder.path().string() + "/";
  for (std::size_t at = 0; (at = text.find(root, at)) != std::string::npos;) text.erase(at, root.size());
  const std::size_t colon = text.find(": ");
  const std::string name = text.substr(0, colon);
  if (name == "-o") throw WrongArgument(kOutput, text.substr(colon + 2));
  for (const ArgumentInfo& argument : command.arguments) {
    if (argument.name == name) throw WrongArgument(argument.key(), text.substr(colon + 2));
  }
  throw WrongArgument("", text);
}

std::string arguments_text(const std::vector<Given>& all) {
  Json json = Json::object();
  for (const auto& [argument, values] : all) {
    if (argument->kind == ArgumentKind::Flag)
      json[argument->key()] = values.front() == "true";
    else if (is_list(*argument))
      json[argument->key()] = values;
    else
      json[argument->key()] = values.front();
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json argument_json(const JobCommand& command, const ArgumentInfo& a) {
  static constexpr std::array kKinds{"positional", "positionals", "option", "repeated", "flag"};
  static constexpr std::array kTypes{"text", "path", "number", "integer", "numbers"};
  std::string joined;
  for (const std::string& choice : a.choices) joined += (joined.empty() ? "" : "|") + choice;
  const auto value = std::find_if(command.values.begin(), command.values.end(),
                                  [&](const auto& pair) { return pair.first == a.key(); });
  return {{"key", a.key()},
          {"name", a.name},
          {"kind", kKinds[static_cast<std::size_t>(a.kind)]},
          {"type", kTypes[static_cast<std::size_t>(a.type)]},
          {"form", a.value_name},
          {"help", a.help},
          {"default", a.has_no_form ? "true" : a.default_text},
          {"value", value == command.values.end() ? "" : value->second},
          {"choices", a.choices},
          {"is_closed", !a.choices.empty() && joined == a.value_name},
          {"is_required", a.is_required},
          {"is_usual", a.is_usual}};
}

}  // namespace

Json JobCommands::json() const {
  Json all = Json::array();
  for (const JobCommand& command : commands_) {
    Json inputs = Json::array(), arguments = Json::array();
    for (const JobInput& input : command.inputs)
      inputs.push_back({{"kinds", input.kinds}, {"title", input.title}, {"may_be_library", input.may_be_library}});
    for (const ArgumentInfo& argument : command.arguments) arguments.push_back(argument_json(command, argument));
    all.push_back({{"name", command.name},
                   {"title", command.title},
                   {"brief", command.brief},
                   {"inputs", std::move(inputs)},
                   {"arguments", std::move(arguments)}});
  }
  return all;
}

JobRequest JobCommands::read(const ServedFolder& folder, JsonReader& reader) const {
  std::vector<std::string_view> names;
  for (const JobCommand& command : commands_) names.emplace_back(command.name);
  const JobCommand& command = commands_[static_cast<std::size_t>(reader.member("command").choice(names))];
  JsonReader values = reader.member("arguments");
  std::vector<Given> all;
  std::size_t input = 0;
  for (const ArgumentInfo& argument : command.arguments) {
    const bool may_be_library =
        argument.is_positional() && input < command.inputs.size() && command.inputs[input++].may_be_library;
    Given given{&argument, {}};
    if (values.has(argument.key())) given = given_of(folder, argument, values.member(argument.key()), may_be_library);
    if (!given.values.empty())
      all.push_back(std::move(given));
    else if (argument.is_required)
      throw WrongArgument(argument.key(), "is missing");  // Else what comes behind it would take its place.
  }
  values.finish();
  const std::string output = reader.has(kOutput) ? checked_output(folder, reader.member(kOutput).string())
                                                 : proposed_output(folder, command, all);
  try {
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    check_(command.name, words_of(folder, all, output, true));
  } catch (const Error& e) {
    fail_argument(folder, command, e.what());
  }
  JobRequest request{
      .command = command.name, .words = split(command.name, ' '), .output = output, .arguments = arguments_text(all)};
  const std::vector<std::string> words = words_of(folder, all, output, false);
  request.words.insert(request.words.end(), words.begin(), words.end());
  return request;
}

}  // namespace patinate::studio
