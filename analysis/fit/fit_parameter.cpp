#include "analysis/fit/fit_parameter.h"

#include <algorithm>
#include <cmath>

#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr int kDigits = 6;  ///< See docs/algorithms/fit.md, Parameters.

/// Problem of a range, "" if there is none.
std::string problem_of(const FitRange& range) {
  const std::string ends = number_text(range.low) + " to " + number_text(range.high);
  if (!(range.low < range.high)) return "the range " + ends + " is upside down or empty; the lower end comes first";
  if (range.scale == FitScale::Log && !(range.low > 0.0)) return "a logarithmic range begins above 0, not " + ends;
  return "";
}

}  // namespace

FitRange parse_fit_range(const std::string& text, const std::string& option) {
  const auto fail = [&](const std::string& expected) -> ParseError {
    return ParseError(option + ": found `" + text + "`; expected " + expected);
  };
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos) throw fail("POINTER=LOW:HIGH[:log], such as /rules/0/rate=0.01:1:log");
  FitRange range{.name = text.substr(0, equals)};
  if (range.name.empty() || range.name.front() != '/')
    throw fail("a JSON pointer into the scene before `=`, such as /rules/0/rate");
  const std::vector<std::string> parts = split(text.substr(equals + 1), ':');
  if (parts.size() < 2 || parts.size() > 3) throw fail("POINTER=LOW:HIGH[:log]");
  const std::optional<double> low = parse_number(parts[0]), high = parse_number(parts[1]);
  if (!low || !high) throw fail("two numbers LOW:HIGH after `=`");
  range.low = *low;
  range.high = *high;
  if (parts.size() == 3) {
    const auto found = std::find(kFitScaleNames.begin(), kFitScaleNames.end(), parts[2]);
    if (found == kFitScaleNames.end())
      throw fail("`log` or `linear` as the third part" +
                 did_you_mean(parts[2], std::vector<std::string>{"linear", "log"}));
    range.scale = static_cast<FitScale>(found - kFitScaleNames.begin());
  }
  if (const std::string problem = problem_of(range); !problem.empty())
    throw ParseError(option + ": `" + text + "`: " + problem);
  return range;
}

FitRange read_fit_range(JsonReader json) {
  FitRange range;
  range.name = json.member("pointer").string();
  if (range.name.empty() || range.name.front() != '/')
    json.member("pointer").fail("a JSON pointer, such as /rules/0/rate");
  range.low = json.member("low").number();
  range.high = json.member("high").number();
  if (json.has("scale")) range.scale = static_cast<FitScale>(json.member("scale").choice(kFitScaleNames));
  if (json.has("own")) range.is_own = json.member("own").boolean();
  json.finish();
  range.place = json.file() + ": " + json.pointer();
  if (const std::string problem = problem_of(range); !problem.empty())
    throw IoError(json.file(), json.pointer() + ": " + problem);
  return range;
}

const std::string& shown_name(const FitParameter& parameter) {
  return parameter.words.empty() ? parameter.range.name : parameter.words;
}

std::string start_problem(const FitParameter& parameter) {
  const FitRange& r = parameter.range;
  if (parameter.start >= r.low && parameter.start <= r.high) return "";
  return r.name + ": starts at " + number_text(parameter.start) + ", outside " + number_text(r.low) + " to " +
         number_text(r.high);
}

double value_at(const FitParameter& parameter, double unit) {
  const FitRange& r = parameter.range;
  if (unit <= 0.0) return r.low;
  if (unit >= 1.0) return r.high;
  const double value =
      r.scale == FitScale::Log ? r.low * std::pow(r.high / r.low, unit) : r.low + unit * (r.high - r.low);
  return std::clamp(parameter.is_whole ? std::round(value) : rounded(value, kDigits), r.low, r.high);
}

double unit_at(const FitParameter& parameter, double value) {
  const FitRange& r = parameter.range;
  const double unit = r.scale == FitScale::Log ? std::log(value / r.low) / std::log(r.high / r.low)
                                               : (value - r.low) / (r.high - r.low);
  return std::clamp(unit, 0.0, 1.0);
}

}  // namespace patinate::analysis
