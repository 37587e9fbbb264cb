/// \file
/// Options from elsewhere than the command line: PATINATE_... variables and the file of --config.
/// Command line > environment > file > default.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tools/patinate/command_line/argument.h"
#include "tools/patinate/command_line/command_line.h"

namespace patinate::cli {

using Environment = std::vector<std::pair<std::string, std::string>>;

/// The process' variables that begin with PATINATE_, without that, in alphabetical order; those left out that are no
/// options (PATINATE_DATA, PATINATE_DECODER, PATINATE_DECODER_SECONDS, PATINATE_LIBRARY, PATINATE_MODULES,
/// PATINATE_OPENCL, PATINATE_STUDIO_JOB).
[[nodiscard]] Environment patinate_environment();

/// Supplies the options of `line` that `environment` names: PATINATE_SPATIAL_SIGMA is --spatial-sigma. Empty variables
/// count as not set.
/// @param commands  Every command, to tell a variable for another command from a typo.
/// @returns what is to be said about variables that are no option of any command.
/// @throws UsageError if a flag is neither true nor false.
std::vector<std::string> supply_environment(CommandLine& line, const Environment& environment,
                                            std::span<const CommandDeclaration> commands);

/// Supplies the options of `line` that a TOML file gives: options of every command at the top, others in the section of
/// their command. Arrays are lists of numbers, or the values of an option that may be repeated. The whole file is
/// checked.
/// @param verb  Whose section counts.
/// @throws IoError naming line and key: no TOML, a section or key that no command has, a value of the wrong type.
void supply_config(CommandLine& line, const std::string& verb, const std::filesystem::path& file,
                   std::span<const CommandDeclaration> commands);

}  // namespace patinate::cli
