#include "tools/patinate/study/study_ranges.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libcommon/core/latin_hypercube.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "tools/patinate/services/fit_scene.h"
#include "tools/patinate/study/design.h"

namespace patinate::cli {

namespace {

constexpr std::size_t kMostValues = 100'000;

/// "/rules/0/rate" is "rate", and "/emitters/0/carries/water" is "water".
std::string last_token(const std::string& pointer) { return pointer.substr(pointer.rfind('/') + 1); }

/// Of the file, as far as it says more than a name: the same number may be whole in one scene only.
std::vector<analysis::FitParameter> parameters_of(const StudyVariation& variation,
                                                  const std::vector<std::filesystem::path>& scenes) {
  std::vector<analysis::FitRange> ranges;
  for (const StudyRange& r : variation.parameters) ranges.push_back(r.range);
  std::vector<analysis::FitParameter> parameters;
  for (const std::filesystem::path& scene : scenes) {
    const FitScene read(scene, ranges, {}, {});
    if (parameters.empty()) parameters = read.parameters();
    for (std::size_t i = 0; i < parameters.size(); ++i)
      parameters[i].is_whole = parameters[i].is_whole || read.parameters()[i].is_whole;
  }
  return parameters;
}

void add_value(StudyLevel& level, const StudyRange& range, double value) {
  level.shown.emplace_back(range.range.name, number_text(value));
  level.pointers.push_back(range.range.name);
  level.values.push_back(value);
}

/// The values of a grid.
std::vector<double> grid_values(const StudyRange& range, const analysis::FitParameter& parameter) {
  if (!range.values.empty()) return range.values;
  if (range.count == 0) throw IoError(range.place, "a grid needs a `count`, or `values`");
  std::vector<double> values;
  for (std::size_t k = 0; k < range.count; ++k) {
    const double share = range.count == 1 ? 0.5 : static_cast<double>(k) / static_cast<double>(range.count - 1);
    const double value = analysis::value_at(parameter, share);
    if (values.empty() || values.back() != value) values.push_back(value);  // Whole numbers may be fewer.
  }
  return values;
}

std::vector<std::vector<StudyLevel>> grid_factors(const StudyVariation& variation,
                                                  const std::vector<analysis::FitParameter>& parameters) {
  std::vector<std::vector<StudyLevel>> factors;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const StudyRange& range = variation.parameters[i];
    std::vector<StudyLevel>& factor = factors.emplace_back();
    for (const double value : grid_values(range, parameters[i])) {
      factor.push_back({.name = last_token(range.range.name) + number_text(value), .shown = {}});
      add_value(factor.back(), range, value);
    }
  }
  return factors;
}

std::vector<StudyLevel> hypercube_factor(const StudyVariation& variation,
                                         const std::vector<analysis::FitParameter>& parameters) {
  std::vector<StudyLevel> factor;
  for (const std::vector<double>& point : latin_hypercube(variation.num_samples, parameters.size(), variation.seed)) {
    factor.push_back({.name = "sample" + zero_padded(factor.size(), 4), .shown = {}});
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const std::vector<double>& list = variation.parameters[i].values;
      add_value(factor.back(), variation.parameters[i],
                list.empty() ? analysis::value_at(parameters[i], point[i])
                             : list[static_cast<std::size_t>(point[i] * static_cast<double>(list.size()))]);
    }
  }
  return factor;
}

std::vector<StudyLevel> list_factor(const StudyVariation& variation, const JsonReader& json) {
  std::vector<StudyLevel> factor;
  const std::size_t length = variation.parameters.empty() ? 0 : variation.parameters.front().values.size();
  for (const StudyRange& range : variation.parameters) {
    if (range.values.size() != length || length == 0)
      throw IoError(json.file(), json.pointer() + "/vary: a list needs `values` everywhere, equally many");
  }
  for (std::size_t k = 0; k < length; ++k) {
    factor.push_back({.name = "sample" + zero_padded(k, 4), .shown = {}});
    for (const StudyRange& range : variation.parameters) add_value(factor.back(), range, range.values[k]);
  }
  return factor;
}

}  // namespace

StudyRange read_study_range(JsonReader json) {
  StudyRange range;
  range.place = json.file() + ": " + json.pointer();
  if (!json.has("values")) {
    if (json.has("count")) range.count = static_cast<std::size_t>(json.member("count").integer(between(1, 1e5)));
    range.range = analysis::read_fit_range(json);
    return range;
  }
  range.range.name = json.member("pointer").string();
  const JsonReader list = json.member("values");
  for (const JsonReader& value : list.elements(kMostValues)) range.values.push_back(value.number());
  if (range.values.empty()) list.fail("at least one value");
  json.finish();
  const auto [least, greatest] = std::minmax_element(range.values.begin(), range.values.end());
  range.range.low = *least;
  range.range.high = *greatest;
  range.range.place = range.place;
  return range;
}

std::vector<std::vector<StudyLevel>> varied_factors(const StudyVariation& variation,
                                                    const std::vector<std::filesystem::path>& scenes,
                                                    const JsonReader& json) {
  if (variation.design == StudyDesign::LatinHypercube && variation.num_samples == 0)
    throw IoError(json.file(), json.pointer() + ": a Latin hypercube needs `samples`");
  const std::vector<analysis::FitParameter> parameters = parameters_of(variation, scenes);
  if (variation.design == StudyDesign::Grid) return grid_factors(variation, parameters);
  if (variation.design == StudyDesign::List) return {list_factor(variation, json)};
  return {hypercube_factor(variation, parameters)};
}

}  // namespace patinate::cli
