#include <nlohmann/json.hpp>

#include "analysis/factorization/factorization_job.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/command_line/path_kind.h"
#include "tools/patinate/command_line/repeating_command.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// What repeats it: options that are not the default, and nothing that changes no byte. @param task  As it was given.
std::string factorize_command(const analysis::FactorizationTask& task) {
  std::string text = "patinate factorize " + input_word(task.history) +
                     (task.of == analysis::FactorQuantity::Color ? "" : " --of " + analysis::name_of(task.of)) +
                     changed_options(option_values(task.options), option_values(analysis::FactorizationOptions{}));
  for (std::size_t i = 0; i < task.times.size(); ++i) text += (i == 0 ? " --times " : ",") + number_text(task.times[i]);
  return text + kAnyOutput;
}

}  // namespace

int cmd_factorize(CommandRun& run) {
  analysis::FactorizationTask task;
  fs::path output;
  std::string of;
  run.line.positional("HISTORY", "A history or a simulation", task.history);
  run.line.output("FOLDER",
                  "Folder to make: factorization.json, report.html, maps/, and history/, the history without noise",
                  output);
  run.line.option("of", "color|roughness|specular|metalness|height",
                  "What is taken apart: the color, or a map that every frame has; the history then has its frames with "
                  "that map without noise",
                  of);
  run.line.choices({analysis::kFactorQuantityNames.begin(), analysis::kFactorQuantityNames.end()});
  run.line.default_text("of", "color");
  run.line.numbers("times", "T,T,...",
                   "Times that the denoised history gets beside its own, in its unit; beyond its ends they are "
                   "extrapolated, and marked so",
                   task.times);
  run.line.options(task.options);
  run.line.without({"seed"});
  run.line.example("factorize copper -o copper_factors");
  run.line.example("factorize copper --times 600,700 -o copper_factors");
  run.line.example("factorize mold --of roughness -o dulling");
  run.line.example("transfer copper_factors/history bust.glb --control rate=accessibility -o aged");
  if (!run.parse()) return 0;
  if (!of.empty()) task.of = analysis::parse_factor_quantity(of);
  task.command = factorize_command(task);
  task.history = history_place(task.history);
  if (kind_of(task.history) != PathKind::History)
    throw InvalidInput(task.history.string() + ": is no history; only those can be factorized");
  const fs::path history = task.history;
  const std::optional<JobStatus> status =
      run.make_folder(analysis::plan_factorization(std::move(task), output), "factorize");
  if (!status) return 0;

  note_history_warnings(run, history.string(), read_history_manifest(history).warnings);
  const Json made = load_json(output / analysis::kFactorizationManifestFile);
  const std::string unit = made.at("time_unit").get<std::string>();
  const auto text = [](const Json& v) { return short_number_text(rounded(v.get<double>(), 3)); };
  for (const Json& f : made.at("frames")) {
    const std::string time = "time " + short_number_text(f.at("time").get<double>()) + " " + unit + ": ";
    if (f.contains("held")) {
      run.note(time +
               "EXTRAPOLATED, and held as it is at the last frame: the curve is not known to foretell better "
               "(forecast_ciede2000, last_frame_ciede2000)");
    } else if (f.contains("extrapolated")) {
      run.note(time + "EXTRAPOLATED, seen by nobody; the curve covers " +
               text(Json(100.0 * f.at("covered_share").get<double>())) +
               " % of what changes, elsewhere its end holds (history/masks)");
    } else if (f.contains("rmse")) {
      run.detail(time + "root mean square " + text(f.at("rmse")) +
                 (f.contains("ciede2000_mean") ? ", CIEDE2000 " + text(f.at("ciede2000_mean")) + ", 95th percentile " +
                                                     text(f.at("ciede2000_p95"))
                                               : ""));
    }
  }
  for (const Json& f : made.at("figures")) {
    const std::string name = f.at("name").get<std::string>();
    run.note(f.at("value").is_null() ? name + ": undefined, " + f.at("undefined").get<std::string>()
                                     : name + ": " + text(f.at("value")) + " " + f.at("unit").get<std::string>());
  }
  run.report_output(*status, output, Json{{"frames", made.at("frames")}, {"figures", made.at("figures")}});
  return 0;
}

}  // namespace patinate::cli
