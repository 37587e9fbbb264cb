/// \file
/// The arguments of one command: positional arguments, options, described options structs, and the options that every
/// command has. Errors are UsageError, with a did-you-mean.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "patinate/core/json.h"
#include "patinate/core/options.h"
#include "tools/patinate/command_line/argument.h"

namespace patinate::cli {

/// Options that every command takes.
struct CommonOptions {
  int threads = 0;
  std::int64_t seed = 1;
  bool json = false;
  bool quiet = false;
  bool verbose = false;
  bool force = false;
  bool dry_run = false;
};
void describe(OptionVisitor& v, CommonOptions& o);

/// Declare arguments, then parse(). Variables keep their value (the default) when an argument is not given. Option
/// names come without dashes; `a_b` is given as `--a-b` or `--a_b`.
class CommandLine {
 public:
  CommandLine(std::string verb, std::string brief);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// In the order in which they are declared. A path is an input, and must exist.
  void positional(const std::string& name, const std::string& help, std::string& value);
  void positional(const std::string& name, const std::string& help, std::filesystem::path& value);
  /// One or more; must be the last positional.
  void positional_list(const std::string& name, const std::string& help, std::vector<std::filesystem::path>& values);
  /// `-o`, required.
  void output(const std::string& name, const std::string& help, std::filesystem::path& value);
  void option(const std::string& name, const std::string& value_name, const std::string& help, std::string& value);
  void option(const std::string& name, const std::string& value_name, const std::string& help,
              std::filesystem::path& value);
  void option(const std::string& name, const std::string& value_name, const std::string& help,
              std::optional<double>& value);
  /// Numbers separated by commas.
  void numbers(const std::string& name, const std::string& value_name, const std::string& help,
               std::vector<double>& values);
  /// May be given several times.
  void repeated(const std::string& name, const std::string& value_name, const std::string& help,
                std::vector<std::string>& values);
  /// Paths that are read, as many as stand behind it, each time it is given.
  void paths(const std::string& name, const std::string& value_name, const std::string& help,
             std::vector<std::filesystem::path>& values);
  void flag(const std::string& name, const std::string& help, bool& value);
  /// One that does nothing any more: it is accepted, and advice() says why.
  void former_flag(const std::string& name, const std::string& why);
  /// Every field of a described options struct. The struct must outlive this.
  template <class Options>
  void options(Options& o) {
    described(std::make_unique<Described<Options>>(o));
  }
  /// Every field of a struct whose options have moved elsewhere: they are accepted, and advice() says what is written
  /// in their place. @param instead  Of an option's key and its value. @param kept  Keys that stay options.
  template <class Options>
  void moved_options(Options& o, std::function<std::string(const std::string& key, const std::string& value)> instead,
                     const std::vector<std::string>& kept) {
    described(std::make_unique<Described<Options>>(o), std::move(instead), kept);
  }

  /// Marks the argument that was declared last as required, or a positional one as not required.
  void required(bool is_required = true);
  /// The file of the argument that was declared last is an output.
  void written();
  /// Nothing else is accepted for the argument that was declared last.
  void choices(const std::vector<std::string>& words);
  /// Suggestions of shells for the argument that was declared last; anything is accepted.
  void suggestions(const std::vector<std::string>& words);
  /// A second name of the option that was declared last.
  void alias(const std::string& name);
  /// Text of --help for the default of an option where that is no fixed value.
  void default_text(const std::string& name, const std::string& text);
  /// Records the choice for an option that was left open, for run.json.
  void decided(const std::string& name, const std::string& value);
  /// Options of which one is given at most: one on the command line puts those of a configuration file out of force.
  void alternatives(const std::vector<std::string>& names);
  /// The few that --help shows first where there are many, beside required ones. @param names  As "texel_size"; those
  /// that are not declared are left out.
  void usual(const std::vector<std::string>& names);
  /// Options of every command that mean nothing to this one.
  void without(const std::vector<std::string>& names);
  /// Adds a check of the arguments, before any input is opened. @param look  Throws UsageError.
  void checked(std::function<void()> look) { checks_.push_back(std::move(look)); }
  /// A list of --help with a title, one name and what it means a line.
  void list(const std::string& title, const std::vector<std::pair<std::string, std::string>>& rows);
  /// Adds a list to --help-all.
  void long_list(const std::string& title, const std::vector<std::pair<std::string, std::string>>& rows);
  /// A line under "Examples" of --help, without "patinate".
  void example(const std::string& arguments);

  /// Advice on what to write in place of moved options that were given, a line each. Call after parse().
  [[nodiscard]] const std::vector<std::string>& advice() const { return advice_; }
  [[nodiscard]] const CommonOptions& common() const { return common_; }
  [[nodiscard]] CommandDeclaration declaration() const;

  /// Reads the words of the command line, then calls `supply`, which may supply() options that they leave open, then
  /// sets all variables.
  /// @returns false when --help was asked for (see help()).
  /// @throws UsageError naming the argument, what was found and what is expected; IoError for what a file supplied.
  [[nodiscard]] bool parse(const std::vector<std::string>& arguments, const std::function<void()>& supply = {});
  /// Gives an option its values unless it, or an alternative of it, has some already.
  /// @param key  "spatial_sigma"; those that this command does not have are ignored.
  /// @param source  Comes before what is said about a wrong value: "PATINATE_SEED", "run.toml: line 3".
  void supply(const std::string& key, const std::vector<std::string>& values, const std::string& source);
  /// Call after parse(). @throws what checked() was given to say.
  void check() const {
    for (const std::function<void()>& look : checks_) look();
  }
  /// The requested help: --help or --help-all.
  [[nodiscard]] std::string help() const { return help_text(declaration(), wants_all_help_); }
  /// The option was given, not left at its default.
  [[nodiscard]] bool is_given(const std::string& name) const;
  /// The --config file; "" when there is none.
  [[nodiscard]] std::string config() const;
  /// Paths that are read, those of options too; `library:NAME` as the folder. Call after parse().
  [[nodiscard]] std::vector<std::filesystem::path> inputs() const;
  /// Requires a file apart from the inputs that is written beside the output; parse() does so for the output itself.
  /// @throws UsageError if it is an input, or lies in a finished result.
  /// @param argument  That names it, as shown.
  void require_apart(const std::string& argument, const std::filesystem::path& file) const;
  /// Every option in force: {"spatial_sigma": {"value": 20, "from": "default"}, ...}. Call after parse().
  [[nodiscard]] Json effective_options() const;

 private:
  Argument& add(Argument argument);
  Argument& add(ArgumentKind kind, ValueType type, const std::string& name, const std::string& value_name,
                const std::string& help, std::function<void(const std::string&)> set);
  void described(std::unique_ptr<DescribedOptions> options,
                 const std::function<std::string(const std::string&, const std::string&)>& instead = {},
                 const std::vector<std::string>& kept = {});
  void read_words(const std::vector<std::string>& arguments, bool& wants_help);
  void read_positionals(std::vector<std::string> rest);
  void assign();
  void assign(Argument& argument);
  [[nodiscard]] Argument* find(const std::string& key) const;

  std::string verb_;
  std::string brief_;
  std::vector<std::string> examples_, advice_;
  std::vector<HelpList> lists_;
  std::vector<std::unique_ptr<Argument>> arguments_;
  std::vector<std::unique_ptr<DescribedOptions>> described_;
  std::vector<std::vector<std::string>> alternatives_;
  std::vector<std::function<void()>> checks_;
  CommonOptions common_;
  bool wants_all_help_ = false;
};

}  // namespace patinate::cli
