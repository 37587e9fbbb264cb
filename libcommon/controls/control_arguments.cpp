#include "libcommon/controls/control_arguments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

namespace {

/// `spray_path` of the kind `spray` is `path`; what consists of the kind's words alone is `file`.
std::string short_name(const std::string& kind, const std::string& option) {
  const std::vector<std::string> of_kind = split(kind, '_');
  std::string name;
  for (const std::string& word : split(option, '_')) {
    if (std::find(of_kind.begin(), of_kind.end(), word) == of_kind.end()) name += (name.empty() ? "" : "_") + word;
  }
  return name.empty() ? "file" : name;
}

constexpr std::array<std::pair<std::string_view, std::array<double, 3>>, 6> kAxes{{{"x", {1.0, 0.0, 0.0}},
                                                                                   {"y", {0.0, 1.0, 0.0}},
                                                                                   {"z", {0.0, 0.0, 1.0}},
                                                                                   {"-x", {-1.0, 0.0, 0.0}},
                                                                                   {"-y", {0.0, -1.0, 0.0}},
                                                                                   {"-z", {0.0, 0.0, -1.0}}}};

/// Sets the option of a name to what a text says.
class OptionSetter final : public OptionVisitor {
 public:
  OptionSetter(std::string_view option, const std::string& shown, const std::string& text)
      : option_(option), shown_(shown), text_(text) {}

  void visit(const OptionInfo& info, double& value) override {
    if (info.name == option_) value = number(info, text_, "a number");
  }
  void visit(const OptionInfo& info, int& value) override {
    if (info.name == option_) value = static_cast<int>(integer(info, 0x1p31 - 1.0));
  }
  void visit(const OptionInfo& info, std::int64_t& value) override {
    if (info.name == option_) value = static_cast<std::int64_t>(integer(info, 0x1p53));
  }
  void visit(const OptionInfo& info, bool& value) override {
    if (info.name != option_) return;
    if (text_ != "true" && text_ != "false") fail("true or false");
    value = text_ == "true";
  }
  void visit(const OptionInfo& info, std::string& value) override {
    if (info.name != option_) return;
    if (text_.empty()) fail("a text");
    value = text_;
  }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    if (info.name == option_) value = number(info, text_, "a number");
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    if (info.name != option_) return;
    const auto* const axis = std::find_if(kAxes.begin(), kAxes.end(), [&](const auto& a) { return a.first == text_; });
    if (axis != kAxes.end() && values.size() == 3) {
      std::copy(axis->second.begin(), axis->second.end(), values.begin());
      return;
    }
    const std::vector<std::string> parts = split(text_, ',');
    const std::string expected = "x, y, z, -x, -y, -z or " + std::to_string(values.size()) + " numbers";
    if (parts.size() != values.size()) fail(expected);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(info, parts[i], expected);
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    if (info.name != option_) return;
    const auto found = std::find(names.begin(), names.end(), text_);
    const std::vector<std::string> words(names.begin(), names.end());
    std::string list;
    for (const std::string& word : words) list += (list.empty() ? "" : ", ") + word;
    if (found == names.end()) fail("one of " + list + did_you_mean(text_, words));
    index = static_cast<int>(found - names.begin());
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    throw ParseError(shown_ + ": found `" + text_ + "`; expected " + expected);
  }
  [[nodiscard]] double number(const OptionInfo& info, const std::string& text, const std::string& expected) const {
    const std::string allowed = info.range.text();
    const std::optional<double> found = parse_number(text);
    if (!found || !info.range.contains(*found)) fail(expected + (allowed.empty() ? "" : " " + allowed));
    return *found;
  }
  [[nodiscard]] double integer(const OptionInfo& info, double most) const {
    const double found = number(info, text_, "an integer");
    if (found != std::floor(found) || !(std::abs(found) <= most)) fail("an integer");
    return found;
  }

  std::string_view option_;
  const std::string& shown_;
  const std::string& text_;
};

}  // namespace

std::vector<std::pair<std::string, std::string>> control_argument_names(const std::string& kind) {
  std::vector<std::pair<std::string, std::string>> names;
  for (const std::string& option : control_option_names(kind)) names.emplace_back(option, short_name(kind, option));
  return names;
}

void set_control_argument(const std::string& kind, std::string& word, const std::string& value,
                          ControlKindOptions& options) {
  const std::string shown = kind + "(" + word + "=...)";
  if (word == "axis") word = "up";
  std::vector<std::string> words;
  std::string list;
  for (const auto& [option, name] : control_argument_names(kind)) {
    if (word == option || word == name) {
      word = option;
      OptionSetter setter(word, shown, value);
      describe(setter, options);
      return;
    }
    words.push_back(name);
    list += (list.empty() ? "" : ", ") + name;
  }
  throw ParseError("`" + kind + "` has no argument `" + word + "`" + did_you_mean(word, words) + "; it has " + list);
}

ControlKindOptions named_options(const ControlName& name, const ControlKindOptions& options) {
  ControlKindOptions named = options;
  for (const auto& [option, value] : name.arguments) {
    std::string word = option;
    set_control_argument(name.text, word, value, named);
  }
  return named;
}

}  // namespace patinate
