/// \file
/// Completion scripts for shells, made from what commands declare.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/patinate/command_line/argument.h"

namespace patinate::cli {

[[nodiscard]] const std::vector<std::string>& completion_shells();
/// A script that a shell sources: commands, options, their choices, and files where a path is wanted.
/// @param shell  One of completion_shells(). @throws InvalidInput if it is none.
[[nodiscard]] std::string completion_script(const std::string& shell, std::span<const CommandDeclaration> commands);

}  // namespace patinate::cli
