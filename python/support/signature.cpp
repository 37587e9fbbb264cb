#include "python/support/signature.h"

#include <optional>
#include <span>
#include <string_view>

#include "libcommon/core/text.h"

namespace patinate::python {

namespace {

std::string& all_stubs() {
  static std::string text;
  return text;
}

std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

/// Options as parameters.
class Texts final : public OptionVisitor {
 public:
  std::vector<ParameterText> parameters;
  void visit(const OptionInfo& info, double& value) override { add(info, "float", number_text(value)); }
  void visit(const OptionInfo& info, int& value) override { add(info, "int", std::to_string(value)); }
  void visit(const OptionInfo& info, std::int64_t& value) override { add(info, "int", std::to_string(value)); }
  void visit(const OptionInfo& info, bool& value) override { add(info, "bool", value ? "True" : "False"); }
  void visit(const OptionInfo& info, std::string& value) override { add(info, "str", in_quotes(value)); }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    add(info, "float | None", value ? number_text(*value) : "None");
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    std::string text;
    for (const double v : values) text += (text.empty() ? "" : ", ") + number_text(v);
    add(info, "Sequence[float]", "(" + text + ")");
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    std::string type;
    for (const std::string_view name : names) type += (type.empty() ? "" : ", ") + in_quotes(name);
    add(info, "Literal[" + type + "]", in_quotes(names[index]));
  }

 private:
  void add(const OptionInfo& info, std::string type, std::string value) {
    std::string help(info.help);
    const std::string range = info.range.text();
    if (!range.empty() || !info.unit.empty()) {
      help += " (" + range + (range.empty() || info.unit.empty() ? "" : " ") + std::string(info.unit) + ")";
    }
    parameters.push_back({std::string(info.name), std::move(type), std::move(help), std::move(value)});
  }
};

/// Lines of at most 100 columns, those behind the first indented.
std::string wrapped(const std::string& text, std::size_t indent) {
  constexpr std::size_t kColumns = 100;
  std::string out;
  std::size_t column = indent;
  for (const std::string& word : split(text, ' ')) {
    if (column > indent && column + 1 + word.size() > kColumns) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      out += " ";
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

std::string entry(const ParameterText& p) {
  const std::string value = p.default_value.empty() ? "" : " = " + p.default_value;
  const std::string help = p.help.empty() ? "" : "    " + wrapped(p.help, 4) + "\n";
  return p.name + ": " + p.type + value + "\n" + help;
}

}  // namespace

std::vector<ParameterText> parameter_texts(DescribedOptions& options) {
  Texts texts;
  options.accept(texts);
  return std::move(texts.parameters);
}

pybind11::object report_of(const pybind11::dict& found) {
  return pybind11::module_::import("patinate._report").attr("Report")(found);
}

const std::string& stubs() { return all_stubs(); }
void add_stub(const std::string& text) { all_stubs() += text; }

void begin_class_stub(const std::string& name, const std::string& doc) {
  add_stub("class " + name + ":\n    \"\"\"" + doc + "\"\"\"\n");
}

FunctionText& FunctionText::takes(std::string name, std::string type, std::string help, std::string default_value) {
  positional_.push_back({std::move(name), std::move(type), std::move(help), std::move(default_value)});
  return *this;
}

FunctionText& FunctionText::keyword(std::string name, std::string type, std::string default_value, std::string help) {
  keywords_.push_back({std::move(name), std::move(type), std::move(help), std::move(default_value)});
  return *this;
}

FunctionText& FunctionText::add_options(DescribedOptions& options) {
  for (ParameterText& p : parameter_texts(options)) keywords_.push_back(std::move(p));
  return *this;
}

FunctionText& FunctionText::runs() {
  keyword("on_progress", "Callable[[float], None] | bool", "False",
          "Called with fractions from 0 to 1; True shows a bar by tqdm where it is installed");
  return keyword("num_threads", "int", "0", "0 = one per processor; never changes a result");
}

FunctionText& FunctionText::returns(std::string type, std::string help) {
  return_type_ = std::move(type);
  return_help_ = std::move(help);
  return *this;
}

FunctionText& FunctionText::raises(std::string text) {
  raises_ = std::move(text);
  return *this;
}

std::string FunctionText::docstring() const {
  // Text before "--" is what inspect.signature() parses; help() shows the rest.
  std::string signature = is_method_ ? "self" : "", body;  // "$self" would be dropped twice of a bound method.
  const auto more = [&](const std::string& text) { signature += (signature.empty() ? "" : ", ") + text; };
  for (const ParameterText& p : positional_) {
    more(p.name + (p.default_value.empty() ? "" : "=" + p.default_value));
    body += entry(p);
  }
  if (!keywords_.empty()) {
    more("*");
    body += "\nBy name:\n";
  }
  for (const ParameterText& p : keywords_) {
    more(p.name + "=" + p.default_value);
    body += entry(p);
  }
  std::string text = name_ + "(" + signature + ")\n--\n\n" + wrapped(brief_, 0) + "\n";
  if (!body.empty()) text += (positional_.empty() ? "" : "\n") + body;
  if (return_type_ != "None")
    text += "\n" + wrapped("Returns " + return_type_ + (return_help_.empty() ? "" : ": " + return_help_), 0) + "\n";
  if (!raises_.empty()) text += "\n" + wrapped("Raises " + raises_, 0) + "\n";
  return text;
}

std::string FunctionText::stub() const {
  const std::string indent = is_method_ ? "    " : "";
  std::string list = is_method_ ? "self" : "";
  const auto more = [&](const std::string& text) { list += (list.empty() ? "" : ", ") + text; };
  for (const ParameterText& p : positional_) more(p.name + ": " + p.type + (p.default_value.empty() ? "" : " = ..."));
  if (!keywords_.empty()) more("*");
  for (const ParameterText& p : keywords_) {
    const bool may_be_none = p.default_value == "None" && p.type.find("None") == std::string::npos;
    more(p.name + ": " + p.type + (may_be_none ? " | None" : "") + " = ...");
  }
  const bool has_doc = !name_.starts_with("__");
  return indent + "def " + name_ + "(" + list + ") -> " + return_type_ + ":" +
         (has_doc ? "\n" + indent + "    \"\"\"" + brief_ + "\"\"\"\n" : " ...\n");
}

}  // namespace patinate::python
