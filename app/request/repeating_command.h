/// \file
/// Command lines that repeat what was done.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace patinate::app {

/// How such a command ends. Like what changes no byte, the output's place is excluded from results: equal work gives
/// equal bytes, and run.json beside them has the command line as it was given.
inline constexpr const char* kAnyOutput = " -o OUT";

/// A word as a shell takes it.
[[nodiscard]] std::string shell_word(const std::string& word);

/// Name of an input wherever it lies: "photos/copper/" and "../copper" are "copper".
[[nodiscard]] std::string input_name(const std::filesystem::path& path);
/// Name of an input as a word.
[[nodiscard]] std::string input_word(const std::filesystem::path& path);

/// " --name value" for every option that is not its default. @param values,defaults  option_values() of both.
[[nodiscard]] std::string changed_options(const std::vector<std::pair<std::string, std::string>>& values,
                                          const std::vector<std::pair<std::string, std::string>>& defaults);

}  // namespace patinate::app
