/// \file
/// The manual, made from what commands declare: as a man page and as Markdown.
#pragma once

#include <span>
#include <string>

#include "tools/patinate/command_line/argument.h"

namespace patinate::cli {

/// patinate.1 in roff, with the macros of man(7). @param version  "0.1.0".
[[nodiscard]] std::string manual_roff(std::span<const CommandDeclaration> commands, const std::string& version);
/// The part of docs/commands.md that lists every command with its options.
[[nodiscard]] std::string manual_markdown(std::span<const CommandDeclaration> commands);

}  // namespace patinate::cli
