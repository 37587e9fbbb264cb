#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "analysis/factorization/factorization_job.h"
#include "app/request/path_kind.h"
#include "app/request/repeating_command.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "patinate/core/error.h"
#include "patinate/history/history.h"
#include "tools/patinate/command_line/history_warnings.h"
#include "tools/patinate/commands/commands.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

/// Command that repeats it: options that are not the default, and nothing that changes no byte. @param task  As it was
/// given.
std::string factorize_command(const analysis::FactorizationTask& task) {
  std::string text = "patinate history factorize " + app::input_word(task.history) +
                     (task.of == analysis::FactorQuantity::Color ? "" : " --of " + analysis::name_of(task.of)) +
                     app::changed_options(option_values(task.options), option_values(analysis::FactorizationOptions{}));
  for (std::size_t i = 0; i < task.times.size(); ++i) text += (i == 0 ? " --times " : ",") + number_text(task.times[i]);
  return text + app::kAnyOutput;
}

constexpr double kMinFollowed = 0.5;

/// Greatest change of a history since its beginning.
struct FollowedChange {
  double time = 0.0;
  double change = 0.0;    ///< Sum of squares over places and channels.
  double followed = 0.0;  ///< Part of it that the reconstruction changes by in the same places and direction, in sum.
};

ImageF frame_of(const HistoryReader& history, int frame, const std::string& of) {
  if (of.empty() || of == "color") return history.read_frame(frame);
  return history.read_frame_extra(frame, of).value_or(ImageF());
}

/// @param made  Has the history's times among others.
FollowedChange followed_change(const HistoryReader& history, const HistoryReader& made, const std::string& of) {
  const std::vector<HistoryFrame>&before = history.manifest().frames, &after = made.manifest().frames;
  const auto made_frame = [&](double time) {
    const auto at = std::min_element(after.begin(), after.end(), [&](const HistoryFrame& a, const HistoryFrame& b) {
      return std::abs(a.time - time) < std::abs(b.time - time);
    });
    return static_cast<int>(at - after.begin());
  };
  const ImageF begin = frame_of(history, 0, of), made_begin = frame_of(made, made_frame(before.front().time), of);
  const int last = static_cast<int>(before.size()) - 1;
  FollowedChange greatest;
  for (const int frame : std::set<int>{last / 4, last / 2, 3 * last / 4, last}) {
    FollowedChange here{.time = before[frame].time};
    const ImageF now = frame_of(history, frame, of), made_now = frame_of(made, made_frame(here.time), of);
    for (const ImageF* other : {&begin, &made_begin, &made_now}) {
      if (other->values().size() != now.values().size()) return {};
    }
    for (std::size_t i = 0; i < now.values().size(); ++i) {
      const double change = static_cast<double>(now.values()[i]) - static_cast<double>(begin.values()[i]);
      here.change += change * change;
      here.followed +=
          change * (static_cast<double>(made_now.values()[i]) - static_cast<double>(made_begin.values()[i]));
    }
    if (here.change > greatest.change) greatest = here;
  }
  return greatest;
}

/// Says first what makes all else of little use.
void note_poor_reconstruction(CommandRun& run, const HistoryReader& history, const HistoryReader& made,
                              const std::string& of) {
  const FollowedChange found = followed_change(history, made, of);
  if (!(found.change > 0.0) || found.followed >= kMinFollowed * found.change) return;
  run.note("warning: the reconstruction has only " + percent_text(std::max(0.0, found.followed / found.change)) +
           " of the history's change at time " + short_number_text(found.time) + " " +
           shown_time_unit(history.manifest().time_unit) +
           ": one curve does not describe this history, or the change is mostly noise; use the history itself");
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
                  "Quantity to factorize: the color, or a map that every frame has; the output history then has its "
                  "frames with that map denoised",
                  of);
  run.line.choices({analysis::kFactorQuantityNames.begin(), analysis::kFactorQuantityNames.end()});
  run.line.default_text("of", "color");
  run.line.numbers("times", "T,T,...",
                   "Times that the denoised history gets beside its own, in its unit; beyond its ends they are "
                   "extrapolated, and marked so",
                   task.times);
  run.line.options(task.options);
  run.line.without({"seed"});
  run.line.example("history factorize copper -o copper_factors");
  run.line.example("history factorize copper --times 600,700 -o copper_factors");
  run.line.example("history factorize mold --of roughness -o dulling");
  run.line.example("transfer copper_factors/history bust.glb --control rate=accessibility -o aged");
  if (!run.parse()) return 0;
  if (!of.empty()) task.of = analysis::parse_factor_quantity(of);
  task.command = factorize_command(task);
  task.history = app::history_place(task.history);
  if (app::kind_of(task.history) != app::PathKind::History)
    throw InvalidInput(task.history.string() + ": is no history; only those can be factorized");
  const fs::path history = task.history;
  const std::optional<JobStatus> status =
      run.make_folder(analysis::plan_factorization(std::move(task), output), "factorize");
  if (!status) return 0;

  note_poor_reconstruction(run, HistoryReader(history), HistoryReader(output / "history"), of);
  refer_to_history_warnings(run, history.string(), read_history_manifest(history).warnings);
  const Json made = load_json(output / analysis::kFactorizationManifestFile);
  const std::string unit = made.at("time_unit").get<std::string>();
  const auto text = [](const Json& v) { return short_number_text(rounded(v.get<double>(), 3)); };
  for (const Json& f : made.at("frames")) {
    const std::string time = "time " + short_number_text(f.at("time").get<double>()) + " " + unit + ": ";
    if (f.contains("held")) {
      run.note(time +
               "EXTRAPOLATED: holds the last frame, because the curve does not predict better (forecast_ciede2000, "
               "last_frame_ciede2000)");
    } else if (f.contains("extrapolated")) {
      run.note(time + "EXTRAPOLATED, not observed: the curve covers " +
               text(Json(100.0 * f.at("covered_share").get<double>())) +
               " % of the changing places; elsewhere its last value is held (history/masks)");
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
