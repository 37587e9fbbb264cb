/// \file
/// One argument of a command: what is declared about it, from which parsing, --help, completion, the manual and the
/// reader of
/// --config are made, and what was found for it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "patinate/core/options.h"

namespace patinate::cli {

enum class ArgumentKind { Positional, PositionalList, Option, Repeated, Flag };
/// Type of its value.
enum class ValueType { Text, Path, Number, Integer, Numbers };

struct ArgumentInfo {
  ArgumentKind kind = ArgumentKind::Option;
  ValueType type = ValueType::Text;
  std::string name;                  ///< Name as shown: MESH, -o, --spatial-sigma.
  std::string alias;                 ///< A second name of an option, "--frames"; or "".
  std::string value_name;            ///< "" for flags.
  std::string help;                  ///< With unit and range, without the default.
  std::string default_text;          ///< "" when there is none.
  std::vector<std::string> choices;  ///< Permitted values; suggestions only where other values are accepted too.
  bool is_required = false;
  bool is_common = false;    ///< An option of every command.
  bool takes_words = false;  ///< An option that may be repeated takes all words up to the next option.
  bool has_no_form = false;  ///< A flag that is on unless `--no-...` is given.
  bool is_written = false;   ///< An option whose file is an output, as that of -o is.
  bool is_moved = false;     ///< Still accepted; no text names it, and who gives it is told what is written instead.
  bool is_usual = false;     ///< One of the few that --help shows of a command with many options.

  [[nodiscard]] bool is_positional() const {
    return kind == ArgumentKind::Positional || kind == ArgumentKind::PositionalList;
  }
  /// The name in a configuration file: spatial_sigma; "output" for -o.
  [[nodiscard]] std::string key() const;
  /// Form as a user gives it: "--threads N", "--no-ground", "MESH".
  [[nodiscard]] std::string form() const;
  /// Description and default, as one sentence of --help and of the manual.
  [[nodiscard]] std::string description() const;
};

struct Argument : ArgumentInfo {
  std::function<void(const std::string&)> set;             ///< Gets each value; for a flag "true" or "false".
  std::function<std::string(const std::string&)> instead;  ///< For a moved one: its value in the form of today.
  std::vector<std::string> found;
  std::string source;  ///< Where `found` comes from, e.g. "run.toml: line 3"; "" = the command line.
};

/// Names and what they mean, e.g. the kinds of control.
struct HelpList {
  std::string title;
  std::vector<std::pair<std::string, std::string>> rows;
  bool is_long = false;  ///< --help leaves it to --help-all.
};

/// Everything that a command says about itself.
struct CommandDeclaration {
  std::string verb;
  std::string brief;
  std::vector<ArgumentInfo> arguments;
  std::vector<HelpList> lists;
  std::vector<std::string> examples;      ///< Without "patinate".
  std::vector<std::string> formers = {};  ///< Names by which it still goes.
};

/// The usage line: "patinate lookup TRANSFER -o IMAGE [options]".
[[nodiscard]] std::string usage_text(const CommandDeclaration& command);
/// A command with more options of its own has a short --help, of its usual and required ones, beside --help-all.
inline constexpr std::size_t kMaxOptionsOfHelp = 12;
/// Text of --help, or of --help-all.
[[nodiscard]] std::string help_text(const CommandDeclaration& command, bool is_all = false);

}  // namespace patinate::cli
