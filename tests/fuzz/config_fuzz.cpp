#include <array>
#include <optional>
#include <string>
#include <vector>

#include "libcommon/core/options.h"
#include "tests/fuzz/fuzz_target.h"
#include "tools/patinate/option_sources.h"

using namespace patinate;

namespace {

struct AnyOptions {
  double sigma = 2.0;
  int bins = 8;
  bool exact = false;
  std::array<double, 3> direction{0, 1, 0};
};
void describe(OptionVisitor& v, AnyOptions& o) {
  v.visit({"sigma", "Width", "px", above(0)}, o.sigma);
  v.visit({"bins", "Bins", "", between(2, 64)}, o.bins);
  v.visit({"exact", "Slowly"}, o.exact);
  v.visit({"direction", "Direction"}, std::span<double>(o.direction));
}

}  // namespace

/// --config: a TOML file for a command with one option of every type.
PATINATE_FUZZ_TARGET(config) {
  CommandLine line{"filter", "Filters."};
  AnyOptions options;
  std::vector<std::string> names;
  std::vector<double> times;
  std::optional<double> time;
  std::filesystem::path output;
  line.output("OUT", "Made", output);
  line.options(options);
  line.repeated("name", "NAME", "Names", names);
  line.numbers("times", "T,T", "Times", times);
  line.option("time", "T", "Time", time);
  line.alternatives({"time", "times"});
  const std::vector<CommandDeclaration> commands{line.declaration(), CommandLine("other", "").declaration()};
  const auto file = fuzz::fuzz_file("run.toml", bytes);
  const std::vector<std::string> words{"-o", "x"};
  (void)line.parse(words, [&] { supply_config(line, "filter", file, commands); });
  fuzz::require(options.sigma > 0.0 && options.bins >= 2 && options.bins <= 64, "options keep to their ranges");
}
