/// \file
/// The numbers of scenes that a study varies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "analysis/fit/fit_parameter.h"
#include "patinate/core/json.h"

namespace patinate::cli {

/// One level of what a study varies.
struct StudyLevel {
  std::string name;                                        ///< Its part of a cell's name; "" = none.
  std::vector<std::pair<std::string, std::string>> shown;  ///< For tables.
  std::vector<std::string> words = {};                     ///< Of the command.
  std::filesystem::path file = {};                         ///< An input.
  std::vector<std::string> pointers = {};                  ///< Numbers of a scene,
  std::vector<double> values = {};                         ///< and what they become.
};

enum class StudyDesign { Grid, LatinHypercube, List };

/// A number of a scene: from a range, or of a list.
struct StudyRange {
  analysis::FitRange range;
  std::size_t count = 0;       ///< Of a grid; 0 = not said.
  std::vector<double> values;  ///< Empty: the range.
  std::string place;           ///< "FILE: POINTER" for messages.
};

struct StudyVariation {
  StudyDesign design = StudyDesign::Grid;
  std::size_t num_samples = 0;  ///< Of a Latin hypercube.
  std::uint64_t seed = 1;       ///< Of a Latin hypercube.
  std::vector<StudyRange> parameters;
};

/// {"pointer", "low", "high", "scale", "count"} or {"pointer", "values"}. @throws IoError
[[nodiscard]] StudyRange read_study_range(JsonReader json);

/// The factors that a variation adds: one a number for a grid, else one in all.
/// @param scenes  Every number is looked for in each, and both ends of its range are tried.
/// @param json  Of the part, for messages. @throws IoError
[[nodiscard]] std::vector<std::vector<StudyLevel>> varied_factors(const StudyVariation& variation,
                                                                  const std::vector<std::filesystem::path>& scenes,
                                                                  const JsonReader& json);

}  // namespace patinate::cli
