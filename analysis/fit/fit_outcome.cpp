#include "analysis/fit/fit_outcome.h"

#include <cmath>

#include "analysis/compare/sections.h"
#include "analysis/fit/chance.h"
#include "analysis/fit/fit_report.h"
#include "analysis/fit/misfit.h"
#include "analysis/fit/multi_start.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/text.h"
#include "patinate/image/image_io.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

/// Share of the rise that the data cannot tell: a best that is higher by no more moves the sides of intervals, where
/// the objective has risen by all of it, by an eighth of their distance (of a parabola: sqrt(1.25)).
constexpr double kLittle = 0.25;

/// Result of a comparison with the history for some values.
struct Compared {
  std::vector<Section> sections;
  MisfitMaps misfit;
  std::optional<double> held_out;        ///< On frames that no search saw.
  ImageF last_captured, last_simulated;  ///< At the last compared time.
  std::string last_time;                 ///< With its unit.
};

/// Writes a capture's history with some values of all parameters.
Compared compared(FitWork& work, std::size_t capture, const std::string& stem, const std::vector<double>& all,
                  const fs::path& folder, const std::string& key, const RunControl& control) {
  const FitModel::Capture model = work.ready(control).captures[capture];
  const std::string name = file_of_capture(work.task.captures.size(), stem, capture);
  const std::vector<double> values = work.model.values_of(capture, all);
  const ComposeWith compose = model.age(values, 0, control.part(0.0, 0.6));
  const RunControl quiet = control.silent();
  const AgedSurface surface = compose(values, quiet);
  write_surface(folder / name, surface, key + "-" + name);
  const CompareOptions options = compare_options(work.task.objective);
  const ComparedPair pair = load_pair(open_series(work.task.captures[capture].history).series,
                                      open_series(folder / name).series, options, control.part(0.6, 0.7));
  std::vector<Section> sections{look_section(pair), colors_section(pair, options, control.part(0.7, 0.85)),
                                controls_section(pair, options, control.part(0.85, 0.9)),
                                structure_section(pair, options, control.part(0.9, 1.0))};
  for (Section& section : sections) embed_pictures(section.pictures, folder / kJobWorkFolder / (name + ".png"));
  const std::size_t last = pair.a.num_times() - 1;
  return {.sections = std::move(sections),
          .misfit = misfit_maps(pair, quiet),
          .held_out = model.held_out ? (*model.held_out)(surface, quiet).objective : std::nullopt,
          .last_captured = pair.a.rgb_image(last),
          .last_simulated = pair.b.rgb_image(last),
          .last_time = short_number_text(rounded(pair.a.times[last], 4)) + " " + pair.time_unit};
}

FitOutcome outcome_of(FitWork& work, const fs::path& folder) {
  FitOutcome outcome;
  outcome.searched = work.searched(folder);
  outcome.best = work.best(folder);
  outcome.initial = outcome.searched.front().points.front();
  outcome.num_planned = work.budget.evaluations;
  for (int s = 1; s <= work.task.options.seeds; ++s)
    outcome.seeds.push_back(work.record(folder, "seed-" + std::to_string(s)));
  outcome.chances = work.chances(folder);

  const FitWork::Ground& ground = work.ground(folder);
  std::vector<BoxPoint> tried = ground.tried;
  outcome.valley = ground.valley;
  outcome.no_valley = ground.no_valley;
  outcome.scans.resize(work.task.parameters.size());
  outcome.profiles.resize(work.task.parameters.size());
  const auto add = [&](std::size_t i, const FitPoint& p, BoxScans& lists) {
    lists[i].push_back(work.box_point(p));
    tried.push_back(lists[i].back());
  };
  if (work.task.options.scan > 0) {
    for (const std::size_t i : work.aged) {
      for (int k = 0; k < work.task.options.scan; ++k) {
        const FitEvaluation e = work.record(folder, "scan-" + std::to_string(i) + "-" + std::to_string(k));
        for (std::size_t q = 0; q < e.points.size(); ++q)
          add(i, e.points[q], q == 0 ? outcome.scans : outcome.profiles);
        if (e.chance) outcome.chances.push_back(*e.chance);
      }
    }
    if (!work.appearance.empty()) {
      const FitEvaluation e = work.record(folder, "scan-appearance");
      std::size_t next = 0;
      for (const std::size_t i : work.appearance) {
        const std::size_t count = work.scan_values(outcome.best.values, i).size();
        for (std::size_t k = 0; k < count && next < e.points.size(); ++k) add(i, e.points[next++], outcome.scans);
      }
    }
  }
  outcome.threshold = untellable_objective(*outcome.best.result.objective, outcome.chances,
                                           static_cast<int>(work.task.parameters.size())) -
                      *outcome.best.result.objective;
  if (work.aged.empty()) {
    outcome.is_converged = outcome.searched.front().is_converged;
  } else {
    const MultiStart search = work.standing(folder, work.num_generations()).search;
    if (std::isfinite(search.lately_gained())) outcome.lately_gained = search.lately_gained();
    outcome.is_converged = search.is_converged() || search.lately_gained() <= kLittle * outcome.threshold;
  }
  outcome.verdicts = determine(work.box_point(outcome.best), tried, outcome.scans, outcome.profiles, outcome.threshold);
  return outcome;
}

/// Over captures; nothing where one has none.
std::optional<double> mean_of_defined(const std::vector<std::optional<double>>& values) {
  double sum = 0.0;
  for (const std::optional<double>& v : values) {
    if (!v) return std::nullopt;
    sum += *v;
  }
  return sum / static_cast<double>(values.size());
}

/// Held-out objectives of all captures together. @param before, after  One a capture.
HeldOut held_out_of(FitWork& work, const FitOutcome& outcome, const std::vector<Compared>& before,
                    const std::vector<Compared>& after, const RunControl& control) {
  HeldOut out;
  std::vector<std::optional<double>> start, best, last;
  out.until = *work.task.objective.until;
  out.time_unit = time_unit_text(open_series(work.task.captures.front().history).series.facts().time_unit);
  for (std::size_t c = 0; c < before.size(); ++c) {
    const FitObjective& held_out = *work.ready(control).captures[c].held_out;
    out.num_times += held_out.num_times();
    start.push_back(before[c].held_out);
    best.push_back(after[c].held_out);
    last.push_back(last_frame_held(held_out, work.task.captures[c].history, *work.task.objective.until, control));
    out.captures.push_back({.name = work.task.captures[c].name,
                            .before = start.back(),
                            .after = best.back(),
                            .last_frame = last.back(),
                            .shown = after[c].last_time});
  }
  out.before = mean_of_defined(start);
  out.after = mean_of_defined(best);
  out.last_frame = mean_of_defined(last);
  for (const FitEvaluation& e : outcome.seeds) out.other_seeds.push_back(e.held_out);
  return out;
}

void write_held_out_pictures(const fs::path& folder, const std::vector<Compared>& after) {
  fs::create_directories(folder / kHeldOutFolder);
  for (std::size_t c = 0; c < after.size(); ++c) {
    write_srgb8(held_out_picture(folder, after.size(), kHeldOutCaptured, c), after[c].last_captured);
    write_srgb8(held_out_picture(folder, after.size(), kHeldOutSimulated, c), after[c].last_simulated);
  }
}

}  // namespace

std::optional<double> last_frame_held(const FitObjective& held_out, const fs::path& history, double until,
                                      const RunControl& control) {
  const SeriesFile file = open_series(history);
  const double first = file.series.facts().frames.front().time;
  double last = first;
  for (const FrameFacts& f : file.series.facts().frames) {
    if (f.time <= until) last = f.time;
  }
  AgedSurface surface{.name = file.series.name(),
                      .time_unit = file.series.facts().time_unit,
                      .texel_size_mm = file.series.pixel_mm(),
                      .times = {first},
                      .colors = {file.series.sample(last)},
                      .mask = file.series.mask(last),
                      .controls = {}};
  for (const ControlFacts& c : file.series.facts().controls)
    surface.controls.push_back({.parameter = c, .values = file.series.control(c.name)});
  return held_out(surface, control).objective;
}

void join_fit(FitWork& work, const fs::path& folder, const std::string& key, const RunControl& control) {
  FitOutcome outcome = outcome_of(work, folder);
  const RunControl quiet = control.silent();
  std::vector<Compared> before, after;
  std::vector<CaptureSections> sections;
  const auto n = static_cast<double>(work.task.captures.size());
  for (std::size_t c = 0; c < work.task.captures.size(); ++c) {
    const auto at = static_cast<double>(c);
    before.push_back(compared(work, c, "before", work.start, folder, key, control.part(at / n, (at + 0.5) / n)));
    after.push_back(
        compared(work, c, "after", outcome.best.values, folder, key, control.part((at + 0.5) / n, (at + 1.0) / n)));
    Section misfit{.name = kMisfitSection, .title = "Where the model lacks colors"};
    misfit.pictures = misfit_pictures(before[c].misfit, after[c].misfit);
    embed_pictures(misfit.pictures, folder / kJobWorkFolder / "misfit.png");
    after[c].sections.push_back(std::move(misfit));
    sections.push_back({std::move(before[c].sections), std::move(after[c].sections)});
    work.task.captures[c].write_model(folder, file_of_capture(work.task.captures.size(), "scene", c),
                                      work.model.values_of(c, outcome.best.values));
  }
  if (work.task.objective.until) {
    outcome.held_out = held_out_of(work, outcome, before, after, quiet);
    write_held_out_pictures(folder, after);
  }
  write_fit_report(folder, work.task, outcome, sections, key);
}

}  // namespace patinate::analysis
