/// \file
/// The table from verb to command.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/patinate/command_line/argument.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

struct Verb {
  const char* name;
  const char* brief;
  int (*run)(CommandRun&);
  /// First positional arguments on which the options depend; nullptr ends the list.
  const char* kinds[10] = {nullptr};
};

[[nodiscard]] std::span<const Verb> verbs();
/// What a command says about itself. Where options depend on the first argument, those of all kinds.
[[nodiscard]] CommandDeclaration declaration_of(const Verb& verb);
[[nodiscard]] std::vector<CommandDeclaration> all_declarations();
/// Reads options as the command would, beside arguments that stand for those that it cannot do without.
/// @param words  Options and their values: {"--quality", "draft"}. @throws UsageError
void check_options(const Verb& verb, const std::vector<std::string>& words);
/// All that a command can say about its arguments before it opens an input. @param words  As check_options().
/// @param output  What -o is given. @throws UsageError
void check_arguments(const Verb& verb, const std::vector<std::string>& words, const std::string& output);
/// What `patinate --help` prints.
[[nodiscard]] std::string overview();

}  // namespace patinate::cli
