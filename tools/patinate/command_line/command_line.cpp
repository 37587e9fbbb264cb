#include "tools/patinate/command_line/command_line.h"

#include <algorithm>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/option_values.h"

namespace patinate::cli {

void describe(OptionVisitor& v, CommonOptions& o) {
  v.visit({"threads", "Threads; 0 = one per processor. Never changes a result", "", between(0, 1024)}, o.threads);
  v.visit({"seed", "Seed of all random choices", "", at_least(0)}, o.seed);
  v.visit({"json", "Print the result as one JSON object on stdout"}, o.json);
  v.visit({"quiet", "Errors only"}, o.quiet);
  v.visit({"verbose", "Print more on stderr: decisions and the time of each stage"}, o.verbose);
  v.visit({"force", "Make the output again, and replace a different one"}, o.force);
  v.visit({"dry_run", "Say what would be done and why, and do nothing"}, o.dry_run);
}

CommandLine::CommandLine(std::string verb, std::string brief) : verb_(std::move(verb)), brief_(std::move(brief)) {
  Described<CommonOptions> common(common_);
  declare_options(common, [this](Argument argument) {
    argument.is_common = true;
    add(std::move(argument));
  });
  add(ArgumentKind::Option, ValueType::Path, "--config", "RUN.toml",
      "Read options from a file; options on the command line override them", [](const std::string&) {})
      .is_common = true;
}
CommandLine::~CommandLine() = default;

Argument& CommandLine::add(Argument argument) {
  arguments_.push_back(std::make_unique<Argument>(std::move(argument)));
  return *arguments_.back();
}

Argument& CommandLine::add(ArgumentKind kind, ValueType type, const std::string& name, const std::string& value_name,
                           const std::string& help, std::function<void(const std::string&)> set) {
  Argument argument;
  argument.kind = kind;
  argument.type = type;
  argument.name = name;
  argument.value_name = value_name;
  argument.help = help;
  argument.set = std::move(set);
  argument.is_required = argument.is_positional();
  return add(std::move(argument));
}

void CommandLine::positional(const std::string& name, const std::string& help, std::string& value) {
  add(ArgumentKind::Positional, ValueType::Text, name, "", help, [&value](const std::string& s) { value = s; });
}
void CommandLine::positional(const std::string& name, const std::string& help, std::filesystem::path& value) {
  add(ArgumentKind::Positional, ValueType::Path, name, "", help, [&value](const std::string& s) { value = s; });
}
void CommandLine::positional_list(const std::string& name, const std::string& help,
                                  std::vector<std::filesystem::path>& values) {
  add(ArgumentKind::PositionalList, ValueType::Path, name, "", help,
      [&values](const std::string& s) { values.emplace_back(s); });
}
void CommandLine::output(const std::string& name, const std::string& help, std::filesystem::path& value) {
  add(ArgumentKind::Option, ValueType::Path, "-o", name, help, [&value](const std::string& s) {
    value = s;
  }).is_required = true;
}
void CommandLine::option(const std::string& name, const std::string& value_name, const std::string& help,
                         std::string& value) {
  add(ArgumentKind::Option, ValueType::Text, dashed(name), value_name, help, [&value](const std::string& s) {
    value = s;
  }).default_text = value;
}
void CommandLine::option(const std::string& name, const std::string& value_name, const std::string& help,
                         std::filesystem::path& value) {
  add(ArgumentKind::Option, ValueType::Path, dashed(name), value_name, help, [&value](const std::string& s) {
    value = s;
  }).default_text = value.string();
}
void CommandLine::option(const std::string& name, const std::string& value_name, const std::string& help,
                         std::optional<double>& value) {
  add(ArgumentKind::Option, ValueType::Number, dashed(name), value_name, help,
      [&value, n = dashed(name)](const std::string& s) { value = number_in(n, s, {}); });
}
void CommandLine::numbers(const std::string& name, const std::string& value_name, const std::string& help,
                          std::vector<double>& values) {
  add(ArgumentKind::Option, ValueType::Numbers, dashed(name), value_name, help,
      [&values, n = dashed(name)](const std::string& s) {
        values.clear();
        for (const std::string& part : split(s, ',')) values.push_back(number_in(n, part, {}));
      });
}
void CommandLine::repeated(const std::string& name, const std::string& value_name, const std::string& help,
                           std::vector<std::string>& values) {
  add(ArgumentKind::Repeated, ValueType::Text, dashed(name), value_name, help,
      [&values](const std::string& s) { values.push_back(s); });
}
void CommandLine::paths(const std::string& name, const std::string& value_name, const std::string& help,
                        std::vector<std::filesystem::path>& values) {
  add(ArgumentKind::Repeated, ValueType::Path, dashed(name), value_name, help, [&values](const std::string& s) {
    values.emplace_back(s);
  }).takes_words = true;
}
void CommandLine::flag(const std::string& name, const std::string& help, bool& value) {
  add(ArgumentKind::Flag, ValueType::Text, dashed(name), "", help,
      [&value](const std::string& s) { value = s == "true"; });
}

void CommandLine::former_flag(const std::string& name, const std::string& why) {
  Argument& argument = add(ArgumentKind::Flag, ValueType::Text, dashed(name), "", why, [](const std::string&) {});
  argument.is_moved = true;
  argument.instead = [why](const std::string&) { return why; };
}

void CommandLine::described(std::unique_ptr<DescribedOptions> options,
                            const std::function<std::string(const std::string&, const std::string&)>& instead,
                            const std::vector<std::string>& kept) {
  declare_options(*options, [&](Argument argument) {
    if (instead && std::find(kept.begin(), kept.end(), argument.key()) == kept.end()) {
      argument.is_moved = true;
      argument.instead = [instead, key = argument.key()](const std::string& value) { return instead(key, value); };
    }
    for (const auto& common : arguments_) {
      if (!common->is_common || common->name != argument.name) continue;
      // The struct has a field that is an option of every command (seed): one option sets both.
      common->set = [first = common->set, second = std::move(argument.set)](const std::string& s) {
        first(s), second(s);
      };
      return;
    }
    add(std::move(argument));
  });
  described_.push_back(std::move(options));
}

void CommandLine::required(bool is_required) { arguments_.back()->is_required = is_required; }

void CommandLine::choices(const std::vector<std::string>& words) {
  Argument& argument = *arguments_.back();
  argument.choices = words;
  argument.set = [words, name = argument.name, set = argument.set](const std::string& s) {
    if (std::find(words.begin(), words.end(), s) != words.end()) return set(s);
    std::string list;
    for (const std::string& word : words) list += (list.empty() ? "" : ", ") + word;
    expect(name, s, "one of " + list + did_you_mean(s, words));
  };
}

void CommandLine::suggestions(const std::vector<std::string>& words) { arguments_.back()->choices = words; }
void CommandLine::written() { arguments_.back()->is_written = true; }
void CommandLine::alias(const std::string& name) { arguments_.back()->alias = dashed(name); }
void CommandLine::alternatives(const std::vector<std::string>& names) { alternatives_.push_back(names); }

void CommandLine::default_text(const std::string& name, const std::string& text) {
  if (Argument* argument = find(name)) argument->default_text = text;
}

void CommandLine::decided(const std::string& name, const std::string& value) {
  if (Argument* argument = find(name); argument != nullptr && argument->found.empty()) {
    argument->default_text = value;
    argument->source = "chosen";
  }
}

void CommandLine::example(const std::string& arguments) { examples_.push_back(arguments); }

void CommandLine::list(const std::string& title, const std::vector<std::pair<std::string, std::string>>& rows) {
  lists_.push_back({title, rows});
}
void CommandLine::long_list(const std::string& title, const std::vector<std::pair<std::string, std::string>>& rows) {
  lists_.push_back({title, rows, true});
}

void CommandLine::usual(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (Argument* argument = find(name)) argument->is_usual = true;
  }
}

void CommandLine::without(const std::vector<std::string>& names) {
  std::erase_if(arguments_, [&](const auto& a) {
    return a->is_common && std::find(names.begin(), names.end(), a->key()) != names.end();
  });
}

CommandDeclaration CommandLine::declaration() const {
  CommandDeclaration result{verb_, brief_, {}, lists_, examples_};
  for (const auto& argument : arguments_) result.arguments.push_back(*argument);
  // Positional ones, what is usual, the rest.
  const auto rank = [](const ArgumentInfo& a) { return a.is_positional() ? 0 : a.is_usual || a.is_required ? 1 : 2; };
  const bool has_usual =
      std::any_of(result.arguments.begin(), result.arguments.end(), [](const auto& a) { return a.is_usual; });
  if (has_usual)
    std::stable_sort(result.arguments.begin(), result.arguments.end(),
                     [&](const ArgumentInfo& a, const ArgumentInfo& b) { return rank(a) < rank(b); });
  return result;
}

Argument* CommandLine::find(const std::string& key) const {
  const std::string alias = dashed(key);
  const auto it = std::find_if(arguments_.begin(), arguments_.end(), [&](const auto& a) {
    return a->key() == key || (!a->alias.empty() && a->alias == alias);
  });
  return it == arguments_.end() ? nullptr : it->get();
}

bool CommandLine::is_given(const std::string& name) const {
  const Argument* argument = find(name == "-o" ? "output" : name);
  return argument != nullptr && !argument->found.empty();
}

std::string CommandLine::config() const {
  const Argument* argument = find("config");
  return argument == nullptr || argument->found.empty() ? "" : argument->found.front();
}

}  // namespace patinate::cli
