/// \file
/// One description per options struct, from which the command line, the JSON form, range checks and content keys are
/// made. An options struct `FooOptions` has one function beside it:
///
///     void describe(OptionVisitor& v, FooOptions& o) {
///       v.visit({"spatial_sigma", "Gaussian window; larger than the widest crack", "px", above(0)},
///       o.spatial_sigma_px); v.visit_choice({"curve", "How transmitted light becomes thickness"}, o.curve,
///       kCurveNames);
///     }
///
/// The defaults are those of the struct and stand nowhere else. Names are snake_case; the command line also takes `-`
/// for `_`.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace patinate {

/// Allowed values, ends included unless said. NaN is never allowed.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool is_low_open = false;

  [[nodiscard]] bool contains(double x) const { return (is_low_open ? x > low : x >= low) && x <= high; }
  /// "> 0", "[8, 4096]", ">= 0" or "" when everything is allowed.
  [[nodiscard]] std::string text() const;
};
[[nodiscard]] inline Range above(double low) { return {.low = low, .is_low_open = true}; }
[[nodiscard]] inline Range at_least(double low) { return {.low = low}; }
[[nodiscard]] inline Range between(double low, double high) { return {.low = low, .high = high}; }

struct OptionInfo {
  std::string_view name;
  std::string_view help;
  std::string_view unit = "";
  Range range = {};
};

/// Visits every field of an options struct, for reading or writing.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void visit(const OptionInfo& info, double& value) = 0;
  virtual void visit(const OptionInfo& info, int& value) = 0;
  virtual void visit(const OptionInfo& info, std::int64_t& value) = 0;
  virtual void visit(const OptionInfo& info, bool& value) = 0;
  virtual void visit(const OptionInfo& info, std::string& value) = 0;
  /// "Not given" stays empty.
  virtual void visit(const OptionInfo& info, std::optional<double>& value) = 0;
  /// Fixed number of values, e.g. a direction (3).
  virtual void visit(const OptionInfo& info, std::span<double> values) = 0;
  virtual void visit_choice_index(const OptionInfo& info, int& index, std::span<const std::string_view> names) = 0;

  /// `names[i]` is the name of the enumerator with value i.
  template <class Enum, std::size_t N>
  void visit_choice(const OptionInfo& info, Enum& value, const std::array<std::string_view, N>& names) {
    int index = static_cast<int>(value);
    visit_choice_index(info, index, names);
    value = static_cast<Enum>(index);
  }
};

/// A described options struct seen without its type.
class DescribedOptions {
 public:
  virtual ~DescribedOptions() = default;
  virtual void accept(OptionVisitor& visitor) = 0;
};

template <class Options>
class Described final : public DescribedOptions {
 public:
  explicit Described(Options& options) : options_(options) {}
  void accept(OptionVisitor& visitor) override { describe(visitor, options_); }

 private:
  Options& options_;
};

/// @throws InvalidInput naming the first option that is out of range, its value and its range.
void check_ranges(DescribedOptions& options);
/// Name and value of every option as text, in order; equal options give equal text (for content keys and provenance).
[[nodiscard]] std::vector<std::pair<std::string, std::string>> option_values(DescribedOptions& options);

template <class Options>
void check_ranges(Options options) {
  Described<Options> described(options);
  check_ranges(static_cast<DescribedOptions&>(described));
}
template <class Options>
[[nodiscard]] std::vector<std::pair<std::string, std::string>> option_values(Options options) {
  Described<Options> described(options);
  return option_values(static_cast<DescribedOptions&>(described));
}

}  // namespace patinate
