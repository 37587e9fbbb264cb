/// \file
/// Command lines that repeat what was done.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace patinate {

/// A word as a shell takes it.
[[nodiscard]] std::string shell_word(const std::string& word);

/// " --name value" for every option that is not its default. @param values,defaults  option_values() of both.
[[nodiscard]] std::string changed_options(const std::vector<std::pair<std::string, std::string>>& values, const std::vector<std::pair<std::string, std::string>>& defaults);

}  // namespace patinate
