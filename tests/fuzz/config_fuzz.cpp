#include <string>
#include <vector>

#include "tests/fuzz/fuzz_target.h"
#include "tests/support/filter_command.h"
#include "tools/patinate/command_line/option_sources.h"

using namespace patinate;

/// --config: a TOML file for a command with one option of every type.
PATINATE_FUZZ_TARGET(config) {
  testing_support::FilterCommand filter;
  const std::vector<cli::CommandDeclaration> commands = filter.commands();
  const auto file = fuzz::fuzz_file("run.toml", bytes);
  const std::vector<std::string> words{"-o", "x"};
  (void)filter.line.parse(words, [&] { cli::supply_config(filter.line, "filter", file, commands); });
  fuzz::require(filter.options.sigma > 0.0 && filter.options.bins >= 2 && filter.options.bins <= 64,
                "options keep to their ranges");
}
