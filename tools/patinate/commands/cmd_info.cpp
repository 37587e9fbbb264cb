#include "tools/patinate/command_line/stats.h"
#include "tools/patinate/command_line/usage_error.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/curves.h"
#include "tools/patinate/services/path_actions.h"

namespace patinate::cli {

int cmd_info(CommandRun& run) {
  std::filesystem::path path;
  run.line.positional("PATH", path_kinds_text(), path);
  CurvesArgument curves;
  curves.declare(run.line);
  StatsArgument stats;
  stats.declare(run.line);
  run.line.without({"seed", "dry_run"});
  run.line.example("info copper");
  run.line.example("info bust.glb --json");
  run.line.example("info crackle --curves curves.csv --by thickness --bins 4 --at 120,80");
  run.line.example("info crackle --stats --csv crackle.csv");
  run.line.example("info banana --stats --class green=#919e39 --class brown=#5c361f");
  if (!run.parse()) return 0;
  if (!curves.file.empty()) return write_curves(run, curves, path);
  if (!stats.csv.empty() && !stats.is_asked) throw UsageError("--csv: is of --stats; give both");
  if (stats.is_asked) return report_stats(run, stats, path);
  facts_of(path).report(run);
  return 0;
}

}  // namespace patinate::cli
