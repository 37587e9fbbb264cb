/// \file
/// What a study's fits search for.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "patinate/core/json.h"
#include "tools/patinate/study/study.h"
#include "tools/patinate/study/study_context.h"

namespace patinate::cli {

/// What is searched for.
struct FitWords {
  std::vector<std::string> words;                ///< Of the command.
  std::size_t num_aged = 0, num_appearance = 0;  ///< Numbers that need aging, and that need none.
};
/// The members `vary` and `objective` of a part, as a file for `fit --parameters` has them.
/// @param scenes  Each must have every number, and start inside its range. @throws IoError
[[nodiscard]] FitWords read_fit_words(JsonReader& part, const std::vector<std::filesystem::path>& scenes,
                                      StudyContext& context);
/// It is a problem where a cell's budget is below what `fit` takes.
void check_fit_budgets(const JsonReader& part, const FitWords& fit, const std::vector<StudyCell>& cells,
                       StudyContext& context);

}  // namespace patinate::cli
