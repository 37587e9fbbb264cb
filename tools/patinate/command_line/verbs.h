/// \file
/// The table from verb to command.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/patinate/command_line/argument.h"
#include "tools/patinate/command_line/command_run.h"

namespace patinate::cli {

struct Verb {
  const char* name;  ///< One word, or two: "fit field".
  const char* brief;
  int (*run)(CommandRun&);
  const char* group;                   ///< Where the first page of help has it.
  const char* formers[3] = {nullptr};  ///< Names by which it still goes; nullptr ends the list.
  /// It makes an output whose work can be told before it is done.
  bool is_planned = true;
  /// First positional arguments on which the options depend; nullptr ends the list.
  const char* kinds[10] = {nullptr};
};

/// Verb that words name, and the number of these words.
struct FoundVerb {
  const Verb* verb = nullptr;
  std::size_t num_words = 0;
  const char* former = nullptr;  ///< The former name that the words have; nullptr = they have the present one.
};

[[nodiscard]] std::span<const Verb> verbs();
/// The command that a command line begins with. @param words  Without "patinate".
[[nodiscard]] std::optional<FoundVerb> find_verb(std::span<const std::string> words);
/// "fit field" is below "fit".
[[nodiscard]] bool is_below(const Verb& verb, const std::string& word);
/// Second words of the commands that begin with this one: {"field", "rank"}.
[[nodiscard]] std::vector<std::string> parts_of(const std::string& word);
/// Each first word once.
[[nodiscard]] std::vector<std::string> first_words();
/// A command line whose command goes by its present name.
[[nodiscard]] std::vector<std::string> by_present_name(const std::vector<std::string>& words);
/// @param words  A command line for which find_verb() finds nothing; not empty. @throws UsageError
[[noreturn]] void fail_no_verb(std::span<const std::string> words);
/// Declaration of a command. Where options depend on the first argument, those of all kinds.
[[nodiscard]] CommandDeclaration declaration_of(const Verb& verb);
[[nodiscard]] std::vector<CommandDeclaration> all_declarations();
/// Reads options as the command would, beside arguments that stand for those that it cannot do without.
/// @param words  Options and their values: {"--quality", "draft"}. @throws UsageError
void check_options(const Verb& verb, const std::vector<std::string>& words);
/// All that a command can say about its arguments before it opens an input. @param words  As check_options().
/// @param output  What -o is given. @throws UsageError
void check_arguments(const Verb& verb, const std::vector<std::string>& words, const std::string& output);
/// Text of `patinate --help`.
[[nodiscard]] std::string overview();
/// Text of `patinate WORD --help` for a word that is no command but begins some.
[[nodiscard]] std::string overview_of(const std::string& word);

}  // namespace patinate::cli
