#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "app/request/history_library.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/job/result_folder.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/command_line.h"
#include "tools/patinate/command_line/option_values.h"

// CommandLine: from words to values.

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Value that was given for an argument other than the output.
struct GivenInput {
  std::string argument;  ///< Argument as shown: "MESH", "--time-map".
  std::string text;
  bool is_path = true;  ///< false: a text that may name files, such as SOURCE=MAP:2 or an expression.
};

/// Without links, "..", and a slash at the end.
fs::path place_of(const fs::path& path) {
  std::error_code error;
  fs::path place = fs::weakly_canonical(fs::absolute(path, error), error).lexically_normal();
  return place.has_filename() ? place : place.parent_path();
}

bool is_inside(const fs::path& place, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), place.begin(), place.end()).first == folder.end();
}

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

/// Files that a text names, as far as they exist: the whole of it, and its words with and without what may be a minus
/// or a plus.
std::vector<fs::path> files_named_by(const std::string& text) {
  std::vector<std::string> words{text};
  for (const char* separators : {" ()*,=:;!|&<>^?", " ()*,=:;!|&<>^?+-"}) {
    for (std::size_t begin = 0; (begin = text.find_first_not_of(separators, begin)) != std::string::npos;) {
      const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
      words.push_back(text.substr(begin, end - begin));
      begin = end;
    }
  }
  std::vector<fs::path> files;
  for (const std::string& word : words) {
    std::error_code error;
    if (fs::is_regular_file(word, error)) files.emplace_back(word);
  }
  return files;
}

/// The files that stand where the output, or one of its numbered images, is to be.
std::vector<fs::path> places_of_output(const fs::path& output) {
  std::vector<fs::path> places{place_of(output)};
  std::string pattern = output.filename().string();
  const std::size_t percent = pattern.find('%'), udim = pattern.find("<UDIM>");
  const std::size_t end = percent == std::string::npos ? std::string::npos : pattern.find('d', percent);
  if (udim != std::string::npos) {
    pattern.replace(udim, 6, "*");
  } else if (end != std::string::npos) {
    pattern.replace(percent, end + 1 - percent, "*");
  } else if (output.has_extension()) {
    pattern = output.stem().string() + ".????" + output.extension().string();  // Tiles: 1001 and so on.
  } else {
    return places;  // A folder, or no image.
  }
  const fs::path folder = place_of(output).parent_path();
  std::error_code error;
  if (!fs::is_directory(folder, error)) return places;
  for (const fs::path& file : list_files(folder, pattern)) places.push_back(place_of(file));
  return places;
}

[[noreturn]] void refuse(const std::string& argument, const fs::path& output, const std::string& why) {
  throw app::UsageError(argument + ": found `" + output.string() + "`, " + why + "; expected another place");
}

/// @param argument  That names the output, as shown: "-o".
/// @throws UsageError if `output` is an input, is a folder that holds one, or lies in a folder that patinate made, of
/// which it is no part.
void require_apart(const std::string& argument, const std::filesystem::path& output,
                   const std::vector<GivenInput>& inputs) {
  const std::vector<fs::path> places = places_of_output(output);
  for (const GivenInput& input : inputs) {
    const std::vector<fs::path> files = input.is_path ? std::vector<fs::path>{input.text} : files_named_by(input.text);
    for (const fs::path& file : files) {
      if (!is_there(file)) continue;
      const fs::path place = place_of(file);
      if (std::find(places.begin(), places.end(), place) != places.end())
        refuse(argument, output, "which is an input (" + input.argument + ") and would be replaced");
      if (is_inside(place, places.front()))
        refuse(argument, output, "which holds an input (" + input.argument + ") and would be replaced");
    }
  }
  const fs::path result = result_around(places.front().parent_path());
  if (!result.empty())
    refuse(argument, output,
           "which lies inside " + result.string() + ", a finished result, which stays as it was made");
}

/// Every spelling of an option, as CLI11 wants them: "--a-b,--a_b".
std::string spellings(const ArgumentInfo& argument) {
  if (argument.name == "-o") return "-o,--output";
  std::string text = argument.name;
  const std::string with_underscores = "--" + argument.key();
  if (with_underscores != argument.name) text += "," + with_underscores;
  if (!argument.alias.empty()) text += "," + argument.alias;
  return text;
}

/// The text of an option as a JSON value of its type.
Json typed(const ArgumentInfo& argument, const std::string& text) {
  if (argument.kind == ArgumentKind::Flag) return text == "true";
  const std::optional<double> number = parse_number(text);
  if (argument.type == ValueType::Integer && number) return static_cast<std::int64_t>(*number);
  if (argument.type == ValueType::Number && number) return *number;
  if (argument.type != ValueType::Numbers) return text;
  Json list = Json::array();
  for (const std::string& part : split(text, ',')) list.push_back(parse_number(part).value_or(0.0));
  return list;
}

Json value_in_force(const ArgumentInfo& argument, const std::vector<std::string>& found) {
  if (argument.kind == ArgumentKind::Repeated) return found;
  if (!found.empty()) return typed(argument, found.front());
  if (argument.kind == ArgumentKind::Flag) return argument.has_no_form;
  return argument.default_text.empty() ? Json(nullptr) : typed(argument, argument.default_text);
}

bool is_output(const ArgumentInfo& argument) { return argument.name == "-o" || argument.is_written; }
bool is_input(const ArgumentInfo& argument) { return argument.type == ValueType::Path && !is_output(argument); }

std::vector<GivenInput> given_inputs(const std::vector<std::unique_ptr<Argument>>& arguments) {
  std::vector<GivenInput> inputs;
  for (const auto& argument : arguments) {
    if (is_output(*argument) || argument->kind == ArgumentKind::Flag) continue;
    for (const std::string& text : argument->found)
      inputs.push_back({argument->name, text, argument->type == ValueType::Path});
  }
  return inputs;
}

/// @throws UsageError if what is made would take the place of what is read.
void require_outputs_apart(const std::vector<std::unique_ptr<Argument>>& arguments) {
  for (const auto& argument : arguments) {
    if (!is_output(*argument)) continue;
    for (const std::string& text : argument->found) require_apart(argument->name, text, given_inputs(arguments));
  }
}

}  // namespace

void CommandLine::require_apart(const std::string& argument, const std::filesystem::path& file) const {
  cli::require_apart(argument, file, given_inputs(arguments_));
}

bool CommandLine::parse(const std::vector<std::string>& arguments, const std::function<void()>& supply) {
  bool wants_help = false;
  read_words(arguments, wants_help);
  if (wants_help) return false;
  if (supply) supply();
  assign();
  return true;
}

void CommandLine::read_words(const std::vector<std::string>& arguments, bool& wants_help) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();  // so that we name the unknown option before anything that it leaves missing
  app.add_flag("-h,--help", wants_help);
  app.add_flag("--help-all", wants_all_help_);
  std::vector<std::string> option_names{"--help", "--help-all"};
  for (const auto& argument : arguments_) {
    if (argument->is_positional()) continue;
    if (!argument->is_moved) option_names.push_back(argument->name == "-o" ? "--output" : argument->name);
    if (argument->kind == ArgumentKind::Flag) {
      app.add_flag_function(spellings(*argument), [&a = *argument](std::int64_t) { a.found = {"true"}; });
      if (!argument->has_no_form) continue;
      const std::string off = "--no-" + argument->name.substr(2);
      if (!argument->is_moved) option_names.push_back(off);
      app.add_flag_function(off, [&a = *argument](std::int64_t) { a.found = {"false"}; });
    } else {
      app.add_option(spellings(*argument), argument->found)->take_all()->allow_extra_args(argument->takes_words);
    }
  }
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Error& e) {
    throw app::UsageError(std::string(e.what()) + "; see `patinate " + verb_ + " --help`");
  }
  wants_help = wants_help || wants_all_help_;
  if (wants_help) return;
  std::vector<std::string> rest = app.remaining();
  const auto end_of_options = std::find(rest.begin(), rest.end(), "--");
  for (auto word = rest.begin(); word != end_of_options; ++word) {
    if (word->size() < 2 || (*word)[0] != '-') continue;
    const std::string name = word->substr(0, word->find('='));
    throw app::UsageError(name + ": `" + verb_ + "` has no such option" +
                          (name.starts_with("--") ? did_you_mean(name, option_names) : ""));
  }
  std::erase(rest, "--");
  read_positionals(std::move(rest));
}

void CommandLine::read_positionals(std::vector<std::string> rest) {
  auto next = rest.begin();
  for (const auto& argument : arguments_) {
    if (argument->kind == ArgumentKind::Positional && next != rest.end()) argument->found = {*next++};
    if (argument->kind == ArgumentKind::PositionalList) argument->found.assign(next, rest.end()), next = rest.end();
  }
  if (next != rest.end()) throw app::UsageError(*next + ": one argument too many; see `patinate " + verb_ + " --help`");
}

void CommandLine::supply(const std::string& key, const std::vector<std::string>& values, const std::string& source) {
  Argument* argument = find(key);
  if (argument == nullptr || argument->is_positional() || !argument->found.empty()) return;
  for (const auto& group : alternatives_) {
    if (std::find(group.begin(), group.end(), key) == group.end()) continue;
    // Two of one source stay, and are named as a contradiction.
    const auto is_given_before = [&](const std::string& name) {
      const Argument* other = find(name);
      return other != nullptr && !other->found.empty() &&
             other->source.substr(0, other->source.find(':')) != source.substr(0, source.find(':'));
    };
    if (std::any_of(group.begin(), group.end(), is_given_before)) return;
  }
  argument->found = values;
  argument->source = source;
}

void CommandLine::assign(Argument& argument) try {
  if (argument.kind == ArgumentKind::Option && argument.found.size() > 1) {
    throw app::UsageError(argument.name + ": is given " + std::to_string(argument.found.size()) +
                          " times; give it once");
  }
  for (const std::string& value : argument.found) {
    if (value.empty() && argument.kind != ArgumentKind::Flag)
      throw app::UsageError(argument.name + ": is empty; give a value");
    argument.set(value);
    if (argument.is_moved) advice_.push_back(argument.name + ": " + argument.instead(value));
  }
} catch (const app::UsageError& e) {
  if (argument.source.empty()) throw;
  const std::string message = argument.source + ": " + e.what();
  if (argument.source.find(':') == std::string::npos) throw app::UsageError(message);
  throw InvalidInput(message);  // It stands in a file.
}

void CommandLine::assign() {
  for (const auto& argument : arguments_) {
    if (argument->is_required && argument->found.empty()) {
      throw app::UsageError(argument->name + ": is missing (" + argument->help + "); see `patinate " + verb_ +
                            " --help`");
    }
  }
  for (const auto& argument : arguments_) {
    if (!is_input(*argument)) continue;
    for (std::string& path : argument->found) path = app::library_place(path).string();
  }
  for (const auto& argument : arguments_) assign(*argument);
  for (const auto& argument : arguments_) {
    if (!argument->is_positional() || argument->type != ValueType::Path) continue;
    for (const std::string& path : argument->found) app::require_exists(path);
  }
  require_outputs_apart(arguments_);
  for (const auto& options : described_) {
    assign_choices(*options, [&](const std::string& name) {
      for (const auto& argument : arguments_) {
        if (argument->name == name && !argument->found.empty()) return argument->found.front();
      }
      return std::string();
    });
  }
}

std::vector<std::filesystem::path> CommandLine::inputs() const {
  std::vector<std::filesystem::path> paths;
  for (const auto& argument : arguments_) {
    if (is_input(*argument)) paths.insert(paths.end(), argument->found.begin(), argument->found.end());
  }
  return paths;
}

Json CommandLine::effective_options() const {
  Json result = Json::object();
  for (const auto& argument : arguments_) {
    if (argument->is_positional()) continue;
    const std::string from = !argument->source.empty() ? argument->source
                             : argument->found.empty() ? "default"
                                                       : "command line";
    result[argument->key()] = Json{{"value", value_in_force(*argument, argument->found)}, {"from", from}};
  }
  return result;
}

}  // namespace patinate::cli
