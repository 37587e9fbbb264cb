/// \file
/// The arguments of one command: positional arguments, options, described options structs, and the options that every command
/// has. Errors are UsageError, with a did-you-mean.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libcommon/core/options.h"

namespace patinate {

/// What every command takes.
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

/// Declare arguments, then parse(). Variables keep their value (the default) when an argument is not given. Option names
/// come without dashes; `a_b` is given as `--a-b` or `--a_b`.
class CommandLine {
 public:
  CommandLine(std::string verb, std::string brief);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// In the order in which they are declared.
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
  void flag(const std::string& name, const std::string& help, bool& value);
  /// Marks the option that was declared last as required.
  void required();
  /// Every field of a described options struct. The struct must outlive this.
  template <class Options>
  void options(Options& o) {
    described(std::make_unique<Described<Options>>(o));
  }
  /// A list of --help with a title, one name and what it means a line.
  void list(const std::string& title, const std::vector<std::pair<std::string, std::string>>& rows);
  /// A line under "Examples" of --help, without "patinate".
  void example(const std::string& arguments);

  [[nodiscard]] const CommonOptions& common() const { return common_; }

  /// @returns false when --help was asked for (see help()).
  /// @throws UsageError naming the argument, what was found and what is expected.
  [[nodiscard]] bool parse(const std::vector<std::string>& arguments);
  [[nodiscard]] std::string help() const;
  /// The option was given, not left at its default.
  [[nodiscard]] bool is_given(const std::string& name) const;

 private:
  struct Entry;
  class Declarer;

  Entry& add(const std::string& name, const std::string& value_name, const std::string& help,
             std::function<void(const std::string&)> set);
  void described(std::unique_ptr<DescribedOptions> options);
  void assign();

  std::string verb_;
  std::string brief_;
  std::vector<std::string> examples_;
  std::string lists_;  ///< As they stand in help().
  std::vector<std::unique_ptr<Entry>> entries_;
  std::vector<std::unique_ptr<DescribedOptions>> described_;
  CommonOptions common_;
};

}  // namespace patinate
