#include "tools/patinate/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libcommon/core/error.h"
#include "libcommon/core/text.h"

namespace patinate {

void describe(OptionVisitor& v, CommonOptions& o) {
  v.visit({"threads", "Threads; 0 = one per processor. Never changes a result", "", between(0, 1024)}, o.threads);
  v.visit({"seed", "Every random choice derives from it", "", at_least(0)}, o.seed);
  v.visit({"json", "The result as one JSON object on stdout"}, o.json);
  v.visit({"quiet", "Errors only"}, o.quiet);
  v.visit({"verbose", "More on stderr"}, o.verbose);
  v.visit({"force", "Replace an existing, different output"}, o.force);
  v.visit({"dry_run", "Say what would be done and why, and do nothing"}, o.dry_run);
}

enum class EntryKind { Positional, PositionalList, Option, Repeated, Flag };

struct CommandLine::Entry {
  EntryKind kind = EntryKind::Option;
  std::string name;        ///< As shown: MESH, -o, --time.
  std::string value_name;  ///< "" for flags.
  std::string help;
  std::string default_text;
  bool is_required = false;
  bool is_common = false;
  std::function<void(const std::string&)> set;  ///< Gets each value; for a flag "true" or "false".
  std::vector<std::string> found;
  std::size_t num_not = 0;  ///< Times that the `--no-` form of a flag was given.
  bool has_no_form = false;

  [[nodiscard]] bool is_positional() const { return kind == EntryKind::Positional || kind == EntryKind::PositionalList; }
};

namespace {

std::string dashed(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return "--" + name;
}

[[noreturn]] void expect(const std::string& name, const std::string& found, const std::string& expected) {
  throw UsageError(name + ": found `" + found + "`; expected " + expected);
}

double number_in(const std::string& name, const std::string& text, const Range& range) {
  const std::string allowed = range.text();
  const std::optional<double> number = parse_number(text);
  if (!number || !range.contains(*number)) expect(name, text, "a number" + (allowed.empty() ? "" : " " + allowed));
  return *number;
}

std::int64_t integer_in(const std::string& name, const std::string& text, const Range& range) {
  const std::string allowed = range.text();
  const std::optional<double> number = parse_number(text);
  if (!number || *number != std::floor(*number) || !(std::abs(*number) <= 0x1p53) || !range.contains(*number)) {
    expect(name, text, "an integer" + (allowed.empty() ? "" : " " + allowed));
  }
  return static_cast<std::int64_t>(*number);
}

std::string joined(std::span<const std::string_view> names, const char* separator) {
  std::string text;
  for (std::string_view name : names) text += (text.empty() ? "" : separator) + std::string(name);
  return text;
}

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

/// Turns each field of an options struct into an option.
class CommandLine::Declarer final : public OptionVisitor {
 public:
  Declarer(CommandLine& line, bool is_common) : line_(line), is_common_(is_common) {}

  void visit(const OptionInfo& info, double& value) override {
    add(info, "X", number_text(value), [&value, range = info.range, name = dashed(std::string(info.name))](
                                           const std::string& s) { value = number_in(name, s, range); });
  }
  void visit(const OptionInfo& info, int& value) override {
    Range range = info.range;
    range.low = std::max(range.low, double{std::numeric_limits<int>::min()});
    range.high = std::min(range.high, double{std::numeric_limits<int>::max()});
    add(info, "N", std::to_string(value), [&value, range, name = dashed(std::string(info.name))](
                                              const std::string& s) { value = static_cast<int>(integer_in(name, s, range)); });
  }
  void visit(const OptionInfo& info, std::int64_t& value) override {
    add(info, "N", std::to_string(value), [&value, range = info.range, name = dashed(std::string(info.name))](
                                              const std::string& s) { value = integer_in(name, s, range); });
  }
  void visit(const OptionInfo& info, bool& value) override {
    Entry& entry = add(info, "", "", [&value](const std::string& s) { value = s == "true"; });
    entry.kind = EntryKind::Flag;
    entry.has_no_form = value;
  }
  void visit(const OptionInfo& info, std::string& value) override {
    add(info, "TEXT", value, [&value](const std::string& s) { value = s; });
  }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    add(info, "X", value ? number_text(*value) : "", [&value, range = info.range, name = dashed(std::string(info.name))](
                                                         const std::string& s) { value = number_in(name, s, range); });
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    std::string shown, form;
    for (double v : values) {
      shown += (shown.empty() ? "" : ",") + number_text(v);
      form += form.empty() ? "X" : ",X";
    }
    add(info, form, shown, [values, range = info.range, name = dashed(std::string(info.name))](const std::string& s) {
      const std::vector<std::string> parts = split(s, ',');
      if (parts.size() != values.size()) {
        expect(name, s, std::to_string(values.size()) + " numbers separated by commas");
      }
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = number_in(name, parts[i], range);
    });
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    // The index belongs to the visit, so the choice is written when the options are visited again (see Assigner).
    const std::string name = dashed(std::string(info.name));
    const std::vector<std::string> words(names.begin(), names.end());
    add(info, joined(names, "|"), words[static_cast<std::size_t>(index)],
        [words, name, all = joined(names, ", ")](const std::string& s) {
          if (std::find(words.begin(), words.end(), s) == words.end()) expect(name, s, "one of " + all + did_you_mean(s, words));
        });
  }

 private:
  Entry& add(const OptionInfo& info, const std::string& value_name, const std::string& default_text,
             std::function<void(const std::string&)> set) {
    std::string help(info.help);
    if (!info.unit.empty()) help += ", " + std::string(info.unit);
    const std::string range = info.range.text();
    if (!range.empty()) help += ", " + range;
    const std::string name = dashed(std::string(info.name));
    for (const auto& common : line_.entries_) {
      if (is_common_ || !common->is_common || common->name != name) continue;
      // The struct has a field that is an option of every command (seed): one option sets both.
      common->set = [first = common->set, second = std::move(set)](const std::string& s) { first(s), second(s); };
      return *common;
    }
    Entry& entry = line_.add(name, value_name, help, std::move(set));
    entry.default_text = default_text;
    entry.is_common = is_common_;
    return entry;
  }

  CommandLine& line_;
  bool is_common_;
};

namespace {

constexpr std::size_t kHelpIndent = 30, kHelpWidth = 110;

/// Writes the choices that were given: they exist as an index only while they are visited.
class ChoiceAssigner final : public OptionVisitor {
 public:
  explicit ChoiceAssigner(std::function<std::string(const std::string&)> given) : given_(std::move(given)) {}
  void visit(const OptionInfo&, double&) override {}
  void visit(const OptionInfo&, int&) override {}
  void visit(const OptionInfo&, std::int64_t&) override {}
  void visit(const OptionInfo&, bool&) override {}
  void visit(const OptionInfo&, std::string&) override {}
  void visit(const OptionInfo&, std::optional<double>&) override {}
  void visit(const OptionInfo&, std::span<double>) override {}
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    const auto it = std::find(names.begin(), names.end(), given_(dashed(std::string(info.name))));
    if (it != names.end()) index = static_cast<int>(it - names.begin());
  }

 private:
  std::function<std::string(const std::string&)> given_;
};

}  // namespace

CommandLine::CommandLine(std::string verb, std::string brief) : verb_(std::move(verb)), brief_(std::move(brief)) {
  Described<CommonOptions> common(common_);
  Declarer declarer(*this, /*is_common=*/true);
  common.accept(declarer);
}
CommandLine::~CommandLine() = default;

CommandLine::Entry& CommandLine::add(const std::string& name, const std::string& value_name, const std::string& help,
                                     std::function<void(const std::string&)> set) {
  entries_.push_back(std::make_unique<Entry>());
  Entry& entry = *entries_.back();
  entry.name = name;
  entry.value_name = value_name;
  entry.help = help;
  entry.set = std::move(set);
  return entry;
}

void CommandLine::positional(const std::string& name, const std::string& help, std::string& value) {
  Entry& entry = add(name, "", help, [&value](const std::string& s) { value = s; });
  entry.kind = EntryKind::Positional;
  entry.is_required = true;
}
void CommandLine::positional(const std::string& name, const std::string& help, std::filesystem::path& value) {
  Entry& entry = add(name, "", help, [&value](const std::string& s) { value = s; });
  entry.kind = EntryKind::Positional;
  entry.is_required = true;
}
void CommandLine::positional_list(const std::string& name, const std::string& help,
                                  std::vector<std::filesystem::path>& values) {
  Entry& entry = add(name, "", help, [&values](const std::string& s) { values.emplace_back(s); });
  entry.kind = EntryKind::PositionalList;
  entry.is_required = true;
}
void CommandLine::output(const std::string& name, const std::string& help, std::filesystem::path& value) {
  add("-o", name, help, [&value](const std::string& s) { value = s; }).is_required = true;
}
void CommandLine::option(const std::string& name, const std::string& value_name, const std::string& help,
                         std::string& value) {
  add(dashed(name), value_name, help, [&value](const std::string& s) { value = s; }).default_text = value;
}
void CommandLine::option(const std::string& name, const std::string& value_name, const std::string& help,
                         std::filesystem::path& value) {
  add(dashed(name), value_name, help, [&value](const std::string& s) { value = s; });
}
void CommandLine::option(const std::string& name, const std::string& value_name, const std::string& help,
                         std::optional<double>& value) {
  add(dashed(name), value_name, help, [&value, n = dashed(name)](const std::string& s) { value = number_in(n, s, {}); });
}
void CommandLine::numbers(const std::string& name, const std::string& value_name, const std::string& help,
                          std::vector<double>& values) {
  add(dashed(name), value_name, help, [&values, n = dashed(name)](const std::string& s) {
    values.clear();
    for (const std::string& part : split(s, ',')) values.push_back(number_in(n, part, {}));
  });
}
void CommandLine::repeated(const std::string& name, const std::string& value_name, const std::string& help,
                           std::vector<std::string>& values) {
  add(dashed(name), value_name, help, [&values](const std::string& s) { values.push_back(s); }).kind = EntryKind::Repeated;
}
void CommandLine::flag(const std::string& name, const std::string& help, bool& value) {
  add(dashed(name), "", help, [&value](const std::string& s) { value = s == "true"; }).kind = EntryKind::Flag;
}
void CommandLine::required() { entries_.back()->is_required = true; }
void CommandLine::example(const std::string& arguments) { examples_.push_back(arguments); }

void CommandLine::described(std::unique_ptr<DescribedOptions> options) {
  Declarer declarer(*this, /*is_common=*/false);
  options->accept(declarer);
  described_.push_back(std::move(options));
}

bool CommandLine::parse(const std::vector<std::string>& arguments) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();  // so that we name the unknown option before anything that it leaves missing
  bool wants_help = false;
  app.add_flag("-h,--help", wants_help);
  std::vector<std::string> option_names{"--help"};
  for (const auto& entry : entries_) {
    if (entry->is_positional()) continue;
    std::string spelled = entry->name;
    if (entry->name != "-o") {
      std::string with_underscores = entry->name.substr(2);
      std::replace(with_underscores.begin(), with_underscores.end(), '-', '_');
      if ("--" + with_underscores != entry->name) spelled += ",--" + with_underscores;
    } else {
      spelled += ",--output";
    }
    option_names.push_back(entry->name == "-o" ? "--output" : entry->name);
    if (entry->kind == EntryKind::Flag) {
      app.add_flag_function(spelled, [&e = *entry](std::int64_t) { e.found = {"true"}; });
      if (entry->has_no_form) app.add_flag("--no-" + entry->name.substr(2), entry->num_not);
    } else {
      app.add_option(spelled, entry->found)->take_all()->allow_extra_args(false);
    }
  }
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Error& e) {
    throw UsageError(std::string(e.what()) + "; see `patinate " + verb_ + " --help`");
  }
  if (wants_help) return false;

  std::vector<std::string> rest = app.remaining();
  bool only_positionals = false;
  for (const std::string& word : rest) {
    only_positionals = only_positionals || word == "--";
    if (only_positionals || word.size() < 2 || word[0] != '-') continue;
    const std::string name = word.substr(0, word.find('='));
    throw UsageError(name + ": `" + verb_ + "` has no such option" +
                     (name.starts_with("--") ? did_you_mean(name, option_names) : ""));
  }
  std::erase(rest, "--");
  auto next = rest.begin();
  for (const auto& entry : entries_) {
    if (entry->kind == EntryKind::Positional && next != rest.end()) entry->found = {*next++};
    if (entry->kind == EntryKind::PositionalList) entry->found.assign(next, rest.end()), next = rest.end();
  }
  if (next != rest.end()) {
    throw UsageError(*next + ": one argument too many; see `patinate " + verb_ + " --help`");
  }
  assign();
  return true;
}

void CommandLine::assign() {
  for (const auto& entry : entries_) {
    if (entry->is_required && entry->found.empty()) {
      throw UsageError(entry->name + ": is missing (" + entry->help + "); see `patinate " + verb_ + " --help`");
    }
    if (entry->num_not > 0) entry->found = {"false"};
    if (entry->kind == EntryKind::Option && entry->found.size() > 1) {
      throw UsageError(entry->name + ": is given " + std::to_string(entry->found.size()) + " times; give it once");
    }
    for (const std::string& value : entry->found) {
      if (value.empty() && entry->kind != EntryKind::Flag) throw UsageError(entry->name + ": is empty; give a value");
      entry->set(value);
    }
  }
  ChoiceAssigner choices([&](const std::string& name) {
    for (const auto& entry : entries_) {
      if (entry->name == name && !entry->found.empty()) return entry->found.front();
    }
    return std::string();
  });
  for (const auto& options : described_) options->accept(choices);
}

bool CommandLine::is_given(const std::string& name) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const auto& e) { return (e->name == dashed(name) || e->name == name) && !e->found.empty(); });
}

void CommandLine::list(const std::string& title, const std::vector<std::pair<std::string, std::string>>& rows) {
  lists_ += "\n" + title + ":\n";
  for (const auto& [name, meaning] : rows) {
    std::string left = "  " + name;
    left.resize(std::max(kHelpIndent, left.size() + 1), ' ');
    lists_ += left + wrapped(meaning, kHelpIndent, kHelpWidth) + "\n";
  }
}

std::string CommandLine::help() const {
  std::string usage = "patinate " + verb_, arguments, own, common;
  for (const auto& entry : entries_) {
    std::string left = "  " + entry->name + (entry->value_name.empty() ? "" : " " + entry->value_name);
    if (entry->has_no_form) left = "  --no-" + entry->name.substr(2);
    if (entry->is_positional() || entry->is_required) {
      usage += " " + left.substr(2) + (entry->kind == EntryKind::PositionalList ? "..." : "");
    }
    std::string help = (entry->has_no_form ? "Without: " : "") + entry->help;
    if (!entry->default_text.empty()) help += "; default " + entry->default_text;
    if (entry->kind == EntryKind::Repeated) help += " (may be repeated)";
    if (left.size() + 2 > kHelpIndent) {
      left += "\n" + std::string(kHelpIndent, ' ');
    } else {
      left.resize(kHelpIndent, ' ');
    }
    (entry->is_positional() ? arguments : entry->is_common ? common : own) += left + wrapped(help, kHelpIndent, kHelpWidth) + "\n";
  }
  std::string text = brief_ + "\n\nUsage: " + usage + " [options]\n";
  if (!arguments.empty()) text += "\n" + arguments;
  if (!own.empty()) text += "\nOptions:\n" + own;
  text += lists_ + "\nEvery command:\n" + common;
  if (!examples_.empty()) text += "\nExamples:\n";
  for (const std::string& example : examples_) text += "  patinate " + example + "\n";
  return text;
}

}  // namespace patinate
