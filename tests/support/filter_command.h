/// \file
/// A command `filter` with one option of every type.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "patinate/core/options.h"
#include "tools/patinate/command_line/command_line.h"

namespace patinate::testing_support {

struct FilterOptions {
  double sigma = 2.0;
  int bins = 8;
  bool exact = false;
  std::array<double, 3> direction{0, 1, 0};
};
inline void describe(OptionVisitor& v, FilterOptions& o) {
  v.visit({"sigma", "Width", "px", above(0)}, o.sigma);
  v.visit({"bins", "Bins", "", between(2, 64)}, o.bins);
  v.visit({"exact", "Slowly"}, o.exact);
  v.visit({"direction", "Direction"}, std::span<double>(o.direction));
}

struct FilterCommand {
  cli::CommandLine line{"filter", "Filters."};
  FilterOptions options;
  std::vector<std::string> names;
  std::vector<double> times;
  std::optional<double> time;
  std::filesystem::path output;

  FilterCommand() {
    line.output("OUT", "Made", output);
    line.options(options);
    line.repeated("name", "NAME", "Names", names);
    line.numbers("times", "T,T", "Times", times);
    line.option("time", "T", "Time", time);
    line.alternatives({"time", "times"});
  }
  /// It and another one without options.
  [[nodiscard]] std::vector<cli::CommandDeclaration> commands() const {
    return {line.declaration(), cli::CommandLine("other", "").declaration()};
  }
};

}  // namespace patinate::testing_support
