#include "analysis/grading/grade_limits.h"

#include <algorithm>
#include <cctype>

#include "analysis/grading/grade_times.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr std::string_view kRetention = "retention";

std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : line + " ") {
    if (c == '#') break;
    if (std::isspace(static_cast<unsigned char>(c)) == 0) {
      word += c;
    } else if (!word.empty()) {
      words.push_back(std::exchange(word, ""));
    }
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::vector<std::string> names_of(const GradeRules& rules) {
  std::vector<std::string> names;
  for (const GradeScale& scale : rules.scales) names.push_back(scale.name);
  for (const std::string_view name : kGradedFigureNames) names.emplace_back(name);
  names.emplace_back("gloss");
  return names;
}

/// One line. Throws InvalidInput.
GradeLimit parse_limit(const std::string& line, const std::vector<std::string>& words, const GradeRules& rules,
                       TimeUnit unit) {
  const auto fail = [&](const std::string& why) -> void { throw InvalidInput("found `" + line + "`; " + why); };
  GradeLimit limit{.text = line};
  std::size_t k = 0;
  limit.name = lower(words[k++]);
  if (k < words.size() && lower(words[k]) == kRetention) {
    limit.is_retention = true;
    ++k;
  }
  const std::vector<std::string> names = names_of(rules);
  if (std::find(names.begin(), names.end(), limit.name) == names.end())
    fail("`" + words[0] + "` is no scale or figure" + did_you_mean(limit.name, names));
  if (limit.name == "gloss") limit.name = "gloss_60";
  if (limit.is_retention && !limit.name.starts_with("gloss")) fail("only gloss has a retention");
  const std::string form = "expected NAME <= VALUE at TIME UNIT, such as `Ri <= 2 at 480 h`";
  if (k >= words.size() || (words[k] != "<=" && words[k] != ">=")) fail(form);
  limit.is_at_most = words[k++] == "<=";
  const std::optional<double> value = k < words.size() ? parse_number(words[k++]) : std::nullopt;
  if (!value) fail(form);
  limit.value = *value;
  if (k < words.size() && words[k] == "%") ++k;
  if (k + 2 >= words.size() || lower(words[k]) != "at") fail(form);
  const std::optional<double> time = parse_number(words[k + 1]);
  if (!time || k + 3 != words.size()) fail(form);
  limit.time = *time * seconds_per(parse_time_unit(words[k + 2])) / seconds_per(unit);
  return limit;
}

/// Value of a region at a time in the limit's terms: a grade as a number, a figure, or percent of the first.
std::optional<GradedFigure> value_at(const GradeLimit& limit, const GradedRegion& region, const GradedSurface& surface,
                                     const GradeRules& rules) {
  const auto scale =
      std::find_if(rules.scales.begin(), rules.scales.end(), [&](const GradeScale& s) { return s.name == limit.name; });
  const std::string figure = scale == rules.scales.end() ? limit.name : scale->figure;
  const std::vector<std::optional<GradedFigure>> series = region.series(figure);
  std::optional<GradedFigure> found = figure_at(surface.times, series, limit.time);
  if (!found) return std::nullopt;
  if (scale != rules.scales.end()) {
    const auto number = [&](double value) { return *parse_number(scale->grades[grade_index(*scale, value)].name); };
    const double a = number(found->low), b = number(found->high);
    return GradedFigure{number(found->value), std::min(a, b), std::max(a, b)};
  }
  if (!limit.is_retention) return found;
  const std::optional<GradedFigure> first =
      surface.unexposed_time ? figure_at(surface.times, series, *surface.unexposed_time) : std::nullopt;
  if (!first || !(first->value > 0.0)) return std::nullopt;
  for (double* end : {&found->value, &found->low, &found->high}) *end *= 100.0 / first->value;
  return found;
}

}  // namespace

std::vector<GradeLimit> read_grade_limits(const std::filesystem::path& file, const GradeRules& rules, TimeUnit unit) {
  std::vector<GradeLimit> limits;
  int number = 0;
  for (const std::string& line : split(read_file(file), '\n')) {
    ++number;
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) continue;
    try {
      limits.push_back(parse_limit(line, words, rules, unit));
    } catch (const InvalidInput& e) {
      throw IoError(file.string(), "line " + std::to_string(number) + ": " + e.what());
    }
  }
  if (limits.empty()) throw IoError(file.string(), "holds no limit; expected lines such as `Ri <= 2 at 480 h`");
  return limits;
}

std::vector<LimitResult> check_limits(const std::vector<GradeLimit>& limits, const GradedSurface& surface,
                                      const GradeRules& rules) {
  std::vector<LimitResult> out;
  for (const GradeLimit& limit : limits) {
    for (const GradedRegion& region : surface.regions) {
      LimitResult result{.limit = limit, .region = region.name};
      const std::optional<GradedFigure> found = value_at(limit, region, surface, rules);
      if (!found) {
        result.state = LimitState::NotTested;
        result.found = "not known at that time";
      } else {
        const auto keeps = [&](double value) { return limit.is_at_most ? value <= limit.value : value >= limit.value; };
        result.state = keeps(found->low) != keeps(found->high) ? LimitState::Undecided
                       : keeps(found->value)                   ? LimitState::Pass
                                                               : LimitState::Fail;
        result.found = figure_text(found->value);
        if (found->low != found->high)
          result.found += " (" + figure_text(found->low) + " to " + figure_text(found->high) + ")";
      }
      out.push_back(std::move(result));
    }
  }
  return out;
}

}  // namespace patinate::analysis
