#include "tools/patinate/command_line/times_argument.h"

namespace patinate::cli {

void TimesArgument::declare(CommandLine& line) {
  line.option("time", "T", "One time, in the history's unit", time);
  line.numbers("times", "T,T,...", "Several times", times);
  line.option("num_times", "N", "Number of times, evenly spaced from the first frame to the last", count);
  line.alias("frames");
  line.alternatives({"time", "times", "num_times"});
  line.checked([this] { check(); });
}

std::vector<double> TimesArgument::resolve(CommandRun& run, const HistoryManifest& history, int default_count) const {
  std::vector<std::string> notes;
  std::vector<double> chosen = TimesChoice::resolve(history, default_count, notes);
  run.notes(notes);
  return chosen;
}

}  // namespace patinate::cli
