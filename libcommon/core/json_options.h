/// \file
/// Reads described options from the members of a JSON object.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/core/options.h"

namespace patinate {

/// Sets every option whose member is given, and leaves the others. @throws IoError with the member's pointer if a value
/// has the wrong type or lies outside of its range.
class JsonOptionReader : public OptionVisitor {
 public:
  void visit(const OptionInfo& info, double& value) override {
    if (const auto json = given(info)) value = json->number(info.range);
  }
  void visit(const OptionInfo& info, int& value) override {
    if (const auto json = given(info)) value = static_cast<int>(json->integer(info.range));
  }
  void visit(const OptionInfo& info, std::int64_t& value) override {
    if (const auto json = given(info)) value = json->integer(info.range);
  }
  void visit(const OptionInfo& info, bool& value) override {
    if (const auto json = given(info)) value = json->boolean();
  }
  void visit(const OptionInfo& info, std::string& value) override {
    if (const auto json = given(info)) value = json->string();
  }
  void visit(const OptionInfo& info, std::optional<double>& value) override {
    if (const auto json = given(info)) value = json->number(info.range);
  }
  void visit(const OptionInfo& info, std::span<double> values) override {
    const auto json = given(info);
    if (!json) return;
    const std::vector<double> numbers = json->numbers(values.size(), info.range);
    std::copy(numbers.begin(), numbers.end(), values.begin());
  }
  void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) override {
    if (const auto json = given(info)) index = json->choice(names);
  }

 protected:
  /// The option's member; nothing where it is not given.
  [[nodiscard]] virtual std::optional<JsonReader> given(const OptionInfo& info) = 0;
};

}  // namespace patinate
