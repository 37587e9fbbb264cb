#include "tools/patinate/command_line/option_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/request/usage_error.h"
#include "libcommon/core/text.h"

namespace patinate::cli {

void expect(const std::string& name, const std::string& found, const std::string& expected) {
  throw app::UsageError(name + ": found `" + found + "`; expected " + expected);
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

namespace {

std::string joined_by(const std::vector<std::string>& words, const char* separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

/// Turns each field of an options struct into an argument.
class Declarer final : public OptionVisitor {
 public:
  explicit Declarer(const std::function<void(Argument)>& declare) : declare_(declare) {}

  void visit(const OptionInfo& info, double& value) override {
    Argument a = argument(info, ValueType::Number, "X", number_text(value));
    a.set = [&value, range = info.range, name = a.name](const std::string& s) { value = number_in(name, s, range); };
    declare_(std::move(a));
  }
  void visit(const OptionInfo& info, int& value) override {
    Range range = info.range;
    range.low = std::max(range.low, double{std::numeric_limits<int>::min()});
    range.high = std::min(range.high, double{std::numeric_limits<int>::max()});
    Argument a = argument(info, ValueType::Integer, "N", std::to_string(value));
    a.set = [&value, range, name = a.name](const std::string& s) {
      value = static_cast<int>(integer_in(name, s, range));
    };
    declare_(std::move(a));
  }
  void visit(const OptionInfo& info, std::int64_t& value) override {
    Argument a = argument(info, ValueType::Integer, "N", std::to_string(value));
    a.set = [&value, range = info.range, name = a.name](const std::string& s) { value = integer_in(name, s, range); };
    declare_(std::move(a));
  }
  void visit(const OptionInfo& info, bool& value) override {
    Argument a = argument(info, ValueType::Text, "", "");
    a.kind = ArgumentKind::Flag;
    a.has_no_form = value;
    a.set = [&value](const std::string& s) { value = s == "true"; };
    declare_(std::move(a));
  }
  void visit(const OptionInfo& info, std::string& value) override {
    Argument a = argument(info, ValueType::Text, "TEXT", value);
    a.set = [&value](const std::string& s) { value = s; };
    declare_(std::move(a));
  }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    Argument a = argument(info, ValueType::Number, "X", value ? number_text(*value) : "");
    a.set = [&value, range = info.range, name = a.name](const std::string& s) { value = number_in(name, s, range); };
    declare_(std::move(a));
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    std::string shown, form;
    for (double v : values) {
      shown += (shown.empty() ? "" : ",") + number_text(v);
      form += form.empty() ? "X" : ",X";
    }
    Argument a = argument(info, ValueType::Numbers, form, shown);
    a.set = [values, range = info.range, name = a.name](const std::string& s) {
      const std::vector<std::string> parts = split(s, ',');
      if (parts.size() != values.size())
        expect(name, s, std::to_string(values.size()) + " numbers separated by commas");
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = number_in(name, parts[i], range);
    };
    declare_(std::move(a));
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    const std::vector<std::string> words(names.begin(), names.end());
    Argument a = argument(info, ValueType::Text, joined_by(words, "|"), words[index]);
    a.choices = words;
    a.set = [words, name = a.name](const std::string& s) {
      if (std::find(words.begin(), words.end(), s) != words.end()) return;
      expect(name, s, "one of " + joined_by(words, ", ") + did_you_mean(s, words));
    };
    declare_(std::move(a));
  }

 private:
  static Argument argument(const OptionInfo& info, ValueType type, const std::string& value_name,
                           const std::string& default_text) {
    Argument a;
    a.type = type;
    a.name = dashed(info.name);
    a.value_name = value_name;
    a.default_text = default_text;
    a.help = std::string(info.help);
    if (!info.unit.empty()) a.help += ", " + std::string(info.unit);
    const std::string range = info.range.text();
    if (!range.empty()) a.help += ", " + range;
    return a;
  }

  const std::function<void(Argument)>& declare_;
};

class ChoiceAssigner final : public OptionVisitor {
 public:
  explicit ChoiceAssigner(const std::function<std::string(const std::string&)>& given) : given_(given) {}
  void visit(const OptionInfo&, double&) override {}
  void visit(const OptionInfo&, int&) override {}
  void visit(const OptionInfo&, std::int64_t&) override {}
  void visit(const OptionInfo&, bool&) override {}
  void visit(const OptionInfo&, std::string&) override {}
  void visit(const OptionInfo&, std::optional<double>&) override {}
  void visit(const OptionInfo&, std::span<double>) override {}
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    const auto it = std::find(names.begin(), names.end(), given_(dashed(info.name)));
    if (it != names.end()) index = static_cast<int>(it - names.begin());
  }

 private:
  const std::function<std::string(const std::string&)>& given_;
};

}  // namespace

void declare_options(DescribedOptions& options, const std::function<void(Argument)>& declare) {
  Declarer declarer(declare);
  options.accept(declarer);
}

void assign_choices(DescribedOptions& options, const std::function<std::string(const std::string& name)>& given) {
  ChoiceAssigner assigner(given);
  options.accept(assigner);
}

}  // namespace patinate::cli
