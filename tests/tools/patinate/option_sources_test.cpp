#include "tools/patinate/command_line/option_sources.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "patinate/core/error.h"
#include "tests/support/filter_command.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

struct Filter : testing_support::FilterCommand {
  /// With the text of a --config file.
  void run(const std::string& toml, std::vector<std::string> words = {}, const cli::Environment& environment = {}) {
    const testing_support::TempFolder temp;
    file = (temp / "run.toml").string();
    write_atomically(file, toml);
    words.insert(words.end(), {"-o", "x"});
    ASSERT_TRUE(line.parse(words, [&] {
      notes = cli::supply_environment(line, environment, commands());
      cli::supply_config(line, "filter", file, commands());
    }));
  }
  std::string file;
  std::vector<std::string> notes;
};

/// Complaint about a file with this text.
std::string complaint(const std::string& toml) {
  Filter filter;
  try {
    filter.run(toml);
  } catch (const InputError& e) {
    const std::string text = e.what();
    EXPECT_EQ(text.find(filter.file + ": line "), 0u) << text;
    return text.substr(filter.file.size() + 2);
  }
  return "";
}

TEST(ConfigFile, GivesEveryKindOfOption) {
  Filter f;
  f.run(
      "threads = 3\n[filter]\nsigma = 4.5\nbins = 16\nexact = true\ndirection = [1, 0.5, -1]\nname = [\"a\", "
      "\"b\"]\ntimes = [0, 2.5]\n");
  EXPECT_EQ(f.line.common().threads, 3);
  EXPECT_EQ(f.options.sigma, 4.5);
  EXPECT_EQ(f.options.bins, 16);
  EXPECT_TRUE(f.options.exact);
  EXPECT_EQ(f.options.direction, (std::array<double, 3>{1, 0.5, -1}));
  EXPECT_EQ(f.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(f.times, (std::vector<double>{0, 2.5}));
}

TEST(ConfigFile, SpellsNamesWithDashesToo) {
  Filter f;
  f.run("dry-run = true\n");
  EXPECT_TRUE(f.line.common().dry_run);
}

TEST(ConfigFile, ComesAfterEnvironmentAndCommandLine) {
  Filter f;
  f.run("threads = 3\nseed = 3\n[filter]\nsigma = 3\n", {"--sigma", "1"}, {{"SIGMA", "2"}, {"THREADS", "2"}});
  EXPECT_EQ(f.options.sigma, 1.0);
  EXPECT_EQ(f.line.common().threads, 2);
  EXPECT_EQ(f.line.common().seed, 3);
  const Json options = f.line.effective_options();
  EXPECT_EQ(options["sigma"]["from"], "command line");
  EXPECT_EQ(options["threads"]["from"], "PATINATE_THREADS");
  EXPECT_EQ(options["seed"]["from"], f.file + ": line 2");
  EXPECT_EQ(options["bins"]["from"], "default");
  EXPECT_EQ(options["sigma"]["value"], 1.0);
}

TEST(ConfigFile, GivesWayToAnAlternativeOnTheCommandLine) {
  Filter f;
  f.run("[filter]\ntimes = [1, 2]\n", {"--time", "7"});
  EXPECT_EQ(f.time, 7.0);
  EXPECT_TRUE(f.times.empty());
}

TEST(ConfigFile, ComplainsWithLineKeyAndWhatWasMeant) {
  EXPECT_EQ(complaint("[filter]\nsigmo = 1\n"),
            "line 2: filter.sigmo: `filter` has no such option; did you mean `sigma`?");
  EXPECT_EQ(complaint("\nthraeds = 1\n"), "line 2: thraeds: there is no such option; did you mean `threads`?");
  EXPECT_EQ(complaint("sigma = 1\n"), "line 1: sigma: is no option of every command; write it under [filter]");
  EXPECT_EQ(complaint("[filtre]\n"), "line 1: [filtre]: there is no such command; did you mean `filter`?");
  EXPECT_EQ(complaint("[filter]\nsigma = \"wide\"\n"),
            "line 2: filter.sigma: found a value of type string; expected a number");
  EXPECT_EQ(complaint("[filter]\nbins = 2.5\n"),
            "line 2: filter.bins: found a value of type floating-point; expected an integer");
  EXPECT_EQ(complaint("[filter]\nexact = 1\n"),
            "line 2: filter.exact: found a value of type integer; expected true or false");
  EXPECT_EQ(complaint("[filter]\nsigma = -1\n"), "line 2: --sigma: found `-1`; expected a number > 0");
  EXPECT_NE(complaint("[filter\n"), "");
  EXPECT_NE(complaint("a = 1\na = 2\n"), "");
  EXPECT_NE(complaint("config = \"other.toml\"\n"), "");
}

TEST(ConfigFile, ChecksTheSectionsOfOtherCommands) {
  EXPECT_NE(complaint("[other]\nsigma = 1\n"), "");
  EXPECT_EQ(complaint("[other]\nthreads = 1\n"), "");
}

TEST(Environment, NamesAreThoseOfOptionsInCapitals) {
  Filter f;
  f.run("", {}, {{"SIGMA", "2.5"}, {"EXACT", "yes"}, {"DIRECTION", "0,0,1"}, {"BINS", ""}});
  EXPECT_EQ(f.options.sigma, 2.5);
  EXPECT_TRUE(f.options.exact);
  EXPECT_EQ(f.options.direction[2], 1.0);
  EXPECT_EQ(f.options.bins, 8) << "an empty variable is not set";
}

TEST(Environment, TellsTyposFromOptions) {
  Filter f;
  f.run("", {}, {{"SIGMAS", "2.5"}});
  ASSERT_EQ(f.notes.size(), 1u);
  EXPECT_EQ(f.notes[0], "PATINATE_SIGMAS: is no option of any command and is ignored; did you mean `PATINATE_SIGMA`?");
}

TEST(Environment, WrongValuesNameTheVariable) {
  Filter f;
  try {
    f.run("", {}, {{"SIGMA", "wide"}});
    ADD_FAILURE();
  } catch (const app::UsageError& e) {
    EXPECT_EQ(std::string(e.what()), "PATINATE_SIGMA: --sigma: found `wide`; expected a number > 0");
  }
}

TEST(Environment, LeavesOutWhatIsNoOption) {
  for (const char* other : {"DATA", "DECODER", "DECODER_SECONDS", "MODULES"}) {
    ::setenv((std::string("PATINATE_") + other).c_str(), "somewhere", 1);
    for (const auto& [name, value] : cli::patinate_environment()) EXPECT_NE(name, other);
  }
}

}  // namespace
}  // namespace patinate
