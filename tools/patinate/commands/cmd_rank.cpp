#include <nlohmann/json.hpp>

#include "analysis/fit/fit_ranking_job.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "patinate/core/error.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

int cmd_rank(CommandRun& run) {
  std::vector<fs::path> fits;
  fs::path output;
  run.line.positional_list("FIT", "Fits with frames held out (fit --until), two or more", fits);
  run.line.output("REPORT", "Folder to make: report.html, report.json, ranking.csv", output);
  run.line.example("fit rank copper_one_layer copper_two_layers -o ranking");
  run.line.example("fit rank one_until_240 one_until_360 two_until_240 two_until_360 -o ranking");
  if (!run.parse()) return 0;
  analysis::RankingTask task{.fits = fits, .names = {}, .command = "patinate fit rank"};
  for (const fs::path& fit : fits) {
    if (app::kind_of(fit) != app::PathKind::Fit)
      throw InvalidInput(fit.string() + ": is no fit; `patinate fit` makes one");
    task.names.push_back(app::input_word(fit));
    task.command += " " + task.names.back();
  }
  task.command += app::kAnyOutput;
  const std::optional<JobStatus> status = run.make_folder(analysis::plan_ranking(std::move(task), output), "rank");
  if (!status) return 0;
  const Json report = load_json(output / analysis::kRankingReportFile);
  for (const Json& sentence : report.at("verdict")) run.note(sentence.get<std::string>());
  run.report_output(*status, output,
                    Json{{"models", report.at("models")},
                         {"cases", report.at("cases")},
                         {"last_frame", report.at("last_frame")},
                         {"verdict", report.at("verdict")}});
  return 0;
}

}  // namespace patinate::cli
