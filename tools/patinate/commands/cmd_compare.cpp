#include <array>
#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/compare/replicates_job.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "app/request/usage_error.h"
#include "libcommon/core/text.h"
#include "patinate/analysis/texture_series.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Command that repeats the comparison: options that are not the default, and nothing that changes no byte. @param task
/// As it was given.
std::string compare_command(const analysis::CompareTask& task) {
  std::string text = "patinate history compare " + app::input_word(task.a) + " " + app::input_word(task.b);
  if (!task.through.empty()) text += " --through " + app::input_word(task.through);
  text += app::changed_options(option_values(task.options), option_values(analysis::CompareOptions{}));
  if (task.options.seed != static_cast<std::uint64_t>(CommonOptions{}.seed))
    text += " --seed " + std::to_string(task.options.seed);
  return text + app::kAnyOutput;
}

std::string compare_command(const analysis::ReplicatesTask& task) {
  std::string text = "patinate history compare";
  for (const fs::path& a : task.a) text += " " + app::input_word(a);
  text += " --against";
  for (const fs::path& b : task.b) text += " " + app::input_word(b);
  text += app::changed_options(option_values(task.options), option_values(analysis::CompareOptions{}));
  if (task.options.seed != static_cast<std::uint64_t>(CommonOptions{}.seed))
    text += " --seed " + std::to_string(task.options.seed);
  return text + app::kAnyOutput;
}

void require_comparable(const fs::path& path) {
  const app::PathKind kind = app::kind_of(path);
  if (kind != app::PathKind::History && kind != app::PathKind::Transfer)
    throw InvalidInput(path.string() + ": is no history or transfer; only those age");
}

/// Replicates of A against those of B.
int compare_replicates(CommandRun& run, analysis::ReplicatesTask task, const fs::path& output) {
  task.command = compare_command(task);
  for (std::vector<fs::path>* side : {&task.a, &task.b}) {
    for (fs::path& path : *side) {
      task.names.push_back(app::input_word(path));
      path = app::history_place(path);
      require_comparable(path);
    }
  }
  const std::optional<JobStatus> status =
      run.make_folder(analysis::plan_replicates(std::move(task), output), "compare");
  if (!status) return 0;
  const Json report = load_json(output / analysis::kCompareReportFile);
  for (const Json& warning : report.at("warnings")) run.note("warning: " + warning.get<std::string>());
  for (const Json& f : report.at("figures")) {
    const auto name = f.at("name").get<std::string>();
    if (f.contains("undefined")) {
      run.note(name + ": undefined, " + f.at("undefined").get<std::string>());
      continue;
    }
    const auto number = [&](const char* member) {
      return f.at(member).is_null() ? "-" : short_number_text(rounded(f.at(member).get<double>(), 3));
    };
    run.note(name + ": A to B " + number("between") + " " + f.at("unit").get<std::string>() + ", within A " +
             number("within_a") + ", within B " + number("within_b") + ", p " + number("p_holm"));
  }
  for (const Json& sentence : report.at("verdict")) run.note(sentence.get<std::string>());
  run.report_output(*status, output,
                    Json{{"figures", report.at("figures")},
                         {"overall_p", report.at("overall_p")},
                         {"verdict", report.at("verdict")},
                         {"warnings", report.at("warnings")}});
  return 0;
}

}  // namespace

int cmd_compare(CommandRun& run) {
  analysis::CompareTask task;
  fs::path output;
  std::vector<fs::path> others, against;
  run.line.positional("A", "A history, a simulation, or a transfer (over time, in its atlas)", task.a);
  run.line.positional_list("B", "What it is compared with: the same; before --against, more replicates of A", others);
  run.line.required(false);
  run.line.output("REPORT", "Folder to make: report.html, report.json, figures.csv, curves/*.csv and *.svg", output);
  run.line.option("through", "TRANSFER", "Look A up through this transfer: B then is in the transfer's atlas",
                  task.through);
  run.line.paths("against", "B...", "Replicates of B, two or more, against two or more of A", against);
  run.line.options(task.options);
  run.line.example("history compare copper_lab copper_outdoors -o report");
  run.line.example("history compare copper copper_simulated --clock span -o report");
  run.line.example("history compare copper hydrant_simulated --through copper_hydrant -o report");
  run.line.example(
      "history compare copper_1 copper_2 copper_3 --against simulated_1 simulated_2 simulated_3 -o report");
  run.line.checked([&] {
    if (task.options.num_blocks == 1)
      throw app::UsageError("--num-blocks: found 1; expected 0, or a number in [2, 64]");
  });
  if (!run.parse()) return 0;
  task.options.seed = static_cast<std::uint64_t>(run.line.common().seed);
  if (!against.empty()) {
    if (!task.through.empty()) throw app::UsageError("--through: goes with two histories, not with --against");
    others.insert(others.begin(), task.a);
    return compare_replicates(
        run, {.a = std::move(others), .b = std::move(against), .names = {}, .options = task.options, .command = {}},
        output);
  }
  if (others.size() != 1)
    throw app::UsageError(others.empty() ? "B: is missing; see `patinate history compare --help`"
                                         : others[1].string() +
                                               ": one argument too many; replicates of B come behind "
                                               "--against");
  task.b = others.front();
  task.command = compare_command(task);
  for (fs::path* side : {&task.a, &task.b}) *side = app::history_place(*side);
  require_comparable(task.a);
  require_comparable(task.b);
  if (!task.through.empty()) app::require_transfer(task.through);
  const std::array<fs::path, 2> sides{task.a, task.b};
  const std::optional<JobStatus> status = run.make_folder(analysis::plan_compare(std::move(task), output), "compare");
  if (!status) return 0;

  for (const fs::path& side : sides)
    refer_to_history_warnings(run, side.string(), analysis::open_series(side).series.facts().warnings);
  const Json report = load_json(output / analysis::kCompareReportFile);
  for (const Json& warning : report.at("warnings")) run.note("warning: " + warning.get<std::string>());
  for (const Json& section : report.at("undefined_sections"))
    run.note(section.at("section").get<std::string>() + ": undefined, " + section.at("reason").get<std::string>());
  for (const Json& f : report.at("figures")) {
    if (f.at("value").is_null()) {
      run.note(f.at("name").get<std::string>() + ": undefined, " + f.at("undefined").get<std::string>());
      continue;
    }
    std::string line = f.at("name").get<std::string>() + ": " +
                       short_number_text(rounded(f.at("value").get<double>(), 3)) + " " +
                       f.at("unit").get<std::string>();
    if (f.contains("split"))
      line += " (A split in two: " + short_number_text(rounded(f.at("split").get<double>(), 3)) + ")";
    run.note(line);
  }
  run.report_output(*status, output,
                    Json{{"figures", report.at("figures")},
                         {"undefined_sections", report.at("undefined_sections")},
                         {"warnings", report.at("warnings")}});
  return 0;
}

}  // namespace patinate::cli
