#include "patinate/core/options.h"

#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate {

std::string Range::text() const {
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  if (has_low && has_high) {
    return (is_low_open ? "(" : "[") + number_text(low) + ", " + number_text(high) + "]";
  }
  if (has_low) return (is_low_open ? "> " : ">= ") + number_text(low);
  if (has_high) return "<= " + number_text(high);
  return "";
}

namespace {

class RangeChecker final : public OptionVisitor {
 public:
  void visit(const OptionInfo& info, double& value) override { check(info, value); }
  void visit(const OptionInfo& info, int& value) override { check(info, value); }
  void visit(const OptionInfo& info, std::int64_t& value) override { check(info, static_cast<double>(value)); }
  void visit(const OptionInfo&, bool&) override {}
  void visit(const OptionInfo&, std::string&) override {}
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    if (value) check(info, *value);
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    for (double v : values) check(info, v);
  }
  void visit_choice_index(const OptionInfo&, int&, std::span<const std::string_view>) override {}

 private:
  static void check(const OptionInfo& info, double value) {
    if (info.range.contains(value) && !std::isnan(value)) return;
    const std::string allowed = info.range.text();
    throw InvalidInput(std::string(info.name) + ": " + number_text(value) + " is out of range; use " +
                       (allowed.empty() ? "a number" : allowed));
  }
};

class ValueCollector final : public OptionVisitor {
 public:
  std::vector<std::pair<std::string, std::string>> values;
  void visit(const OptionInfo& info, double& value) override { put(info, number_text(value)); }
  void visit(const OptionInfo& info, int& value) override { put(info, std::to_string(value)); }
  void visit(const OptionInfo& info, std::int64_t& value) override { put(info, std::to_string(value)); }
  void visit(const OptionInfo& info, bool& value) override { put(info, value ? "true" : "false"); }
  void visit(const OptionInfo& info, std::string& value) override { put(info, value); }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    put(info, value ? number_text(*value) : "");
  }
  void visit(const OptionInfo& info, std::span<double> numbers) override {
    std::string text;
    for (double v : numbers) text += (text.empty() ? "" : ",") + number_text(v);
    put(info, text);
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    put(info, std::string(names[index]));
  }

 private:
  void put(const OptionInfo& info, std::string text) { values.emplace_back(info.name, std::move(text)); }
};

}  // namespace

void check_ranges(DescribedOptions& options) {
  RangeChecker checker;
  options.accept(checker);
}

std::vector<std::pair<std::string, std::string>> option_values(DescribedOptions& options) {
  ValueCollector collector;
  options.accept(collector);
  return std::move(collector.values);
}

}  // namespace patinate
