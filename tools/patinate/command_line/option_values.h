/// \file
/// Text of the command line as values, and the fields of described options structs as arguments.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "tools/patinate/command_line/argument.h"

namespace patinate::cli {

/// @throws UsageError "NAME: found `FOUND`; expected EXPECTED".
[[noreturn]] void expect(const std::string& name, const std::string& found, const std::string& expected);
/// @throws UsageError
[[nodiscard]] double number_in(const std::string& name, const std::string& text, const Range& range);
[[nodiscard]] std::int64_t integer_in(const std::string& name, const std::string& text, const Range& range);

/// Calls `declare` with an argument for every field that `options` describes. Choices are written by assign_choices().
void declare_options(DescribedOptions& options, const std::function<void(Argument)>& declare);

/// Writes the choices that were given: they exist as an index only while they are visited.
/// @param given  Value of an option by its name ("--method"), "" if it was not given.
void assign_choices(DescribedOptions& options, const std::function<std::string(const std::string& name)>& given);

}  // namespace patinate::cli
