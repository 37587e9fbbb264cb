#include "analysis/fit/fit_report.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/fit/fit_page.h"
#include "analysis/report/analysis_documents.h"
#include "libcommon/core/files.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

std::vector<FigureChange> figure_changes(const CaptureSections& capture) {
  const auto& [before, after] = capture;
  std::map<std::string, std::optional<double>> values;
  for (const Section& s : after) {
    for (const Figure& f : s.figures) values[f.name] = as_stated(f).value;
  }
  std::vector<FigureChange> changes;
  for (const Section& s : before) {
    for (const Figure& f : s.figures) {
      const auto found = values.find(f.name);
      changes.push_back({as_stated(f), found == values.end() ? std::nullopt : found->second});
    }
  }
  return changes;
}

FittedNumber fitted_number(const FitTask& task, const FitOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  const ParameterVerdict& v = o.verdicts[i];
  return {.pointer = p.range.name,
          .words = shown_name(p),
          .unit = p.unit,
          .capture = p.capture ? task.captures[*p.capture].name : "",
          .low = p.range.low,
          .high = p.range.high,
          .scale = p.range.scale,
          .needs_aging = !p.is_appearance,
          .initial = o.initial.values[i],
          .best = o.best.values[i],
          .interval = {value_at(p, v.low), value_at(p, v.high)},
          .found = v,
          .verdict = verdict_text(task, o, i)};
}

/// Of the objective and what was found of it.
FitManifest manifest_of(const FitTask& task, const FitOutcome& o, const std::string& key) {
  FitManifest m;
  m.model = task.model_name;
  m.objective_before = o.initial.result.objective;
  m.objective_after = *o.best.result.objective;
  for (std::size_t i = 0; i < task.terms.size(); ++i) {
    const auto which = static_cast<std::size_t>(task.terms[i].figure);
    m.terms.push_back({std::string(kFitFigureNames[which]), task.terms[i].weight, std::string(kFitFigureUnits[which]),
                       o.initial.result.figures[i], o.best.result.figures[i]});
  }
  for (const FitEvaluation& e : o.seeds) m.other_seeds.push_back(e.points.front().result.objective);
  m.chances = o.chances, m.threshold = o.threshold;
  m.held_out = o.held_out;
  for (std::size_t i = 0; i < task.parameters.size(); ++i) m.numbers.push_back(fitted_number(task, o, i));
  if (o.valley) m.correlation = o.valley->correlation;
  m.no_correlation = o.no_valley;
  m.num_planned = o.num_planned, m.num_agings = count_agings(o), m.num_points = count_points(o);
  m.is_converged = o.is_converged, m.lately_gained = o.lately_gained;
  Named<std::string> options = option_values(task.objective);
  for (const auto& option : option_values(task.options)) options.push_back(option);
  m.origin = {with_seed(options, task.seed), task.command, key};
  return m;
}

/// Name and key of the history, or of all together.
void add_histories(FitManifest& m, const std::vector<SeriesFile>& files, const FitTask& task, const FitOutcome& o) {
  for (const SeriesFile& file : files) m.history_key += (m.history_key.empty() ? "" : " ") + file.key();
  m.history = files.size() == 1 ? files.front().series.name() : captures_text(task);
  for (std::size_t c = 0; c < files.size() && files.size() > 1; ++c)
    m.captures.push_back(
        {task.captures[c].name, files[c].series.name(), files[c].key(), o.initial.captures[c], o.best.captures[c]});
}

constexpr DocumentKind kFitDocument{.format = "patinate.fit",
                                    .version = 2,
                                    .title = "patinate fit",
                                    .about = "report.json of `patinate fit`: the figures of the page beside it."};

}  // namespace

int count_agings(const FitOutcome& o) {
  return static_cast<int>(
      std::count_if(o.searched.begin(), o.searched.end(), [](const FitEvaluation& e) { return !e.points.empty(); }));
}
int count_points(const FitOutcome& o) {
  std::size_t n = 0;
  for (const FitEvaluation& e : o.searched) n += e.points.size();
  return static_cast<int>(n);
}

std::string captures_text(const FitTask& task) {
  std::string text;
  for (std::size_t c = 0; c < task.captures.size(); ++c)
    text += (c == 0 ? "" : c + 1 == task.captures.size() ? " and " : ", ") + task.captures[c].name;
  return text;
}

void write_fit_report(const fs::path& folder, const FitTask& task, const FitOutcome& o,
                      std::span<const CaptureSections> captures, const std::string& key) {
  const bool are_several = captures.size() > 1;
  std::vector<SeriesFile> files;
  std::vector<std::vector<FigureChange>> changes;
  std::vector<std::string> parameter_names, capture_names;
  FitManifest m = manifest_of(task, o, key);
  for (std::size_t c = 0; c < captures.size(); ++c) {
    files.push_back(open_series(task.captures[c].history));
    if (are_several) capture_names.push_back(task.captures[c].name);
    changes.push_back(figure_changes(captures[c]));
    for (FigureChange& change : changes.back()) {
      change.capture = are_several ? task.captures[c].name : "";
      m.figures.push_back(change);
    }
  }
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    const std::string& unit = task.parameters[i].unit;
    parameter_names.push_back(column_of(task, i) + (unit.empty() ? "" : " [" + unit + "]"));
  }
  const std::string title =
      task.model_name + " fitted to " + (are_several ? captures_text(task) : files.front().series.name());
  write_fit_page(folder, title, task, o, captures, changes);
  write_atomically(folder / kFitTableFile, evaluations_csv(o.searched, parameter_names, capture_names, task.terms));
  add_histories(m, files, task, o);
  save_json(folder / kFitReportFile, document_json(kFitDocument, described(m)));
}

void describe(DocumentVisitor& v, FittedTerm& t) {
  v.member({"figure"}, t.figure);
  v.member({"unit"}, t.unit);
  v.member({"weight", "", above(0)}, t.weight);
  v.member(or_null("before"), t.before);
  v.member(or_null("after"), t.after);
}

void describe(DocumentVisitor& v, HeldOutCapture& c) {
  v.member({"name"}, c.name);
  v.member(or_null("before"), c.before);
  v.member(or_null("after"), c.after);
  v.member(or_null("last_frame"), c.last_frame);
  v.member({"shown", "Time of its pictures, with its unit."}, c.shown);
}

void describe(DocumentVisitor& v, HeldOut& h) {
  v.member({"until", "In the history's unit of time."}, h.until);
  v.member({.name = "unit", .help = "That unit: \"min\".", .presence = Presence::Optional}, h.time_unit);
  v.member({"times", "", at_least(1)}, h.num_times);
  v.member(or_null("before", "With the starting values.", at_least(0)), h.before);
  v.member(or_null("after", "With the best values.", at_least(0)), h.after);
  v.member({.name = "other_seeds",
            .help = "The best values with other seeds of the simulation.",
            .range = at_least(0),
            .has_nulls = true},
           h.other_seeds);
  v.member(or_null("last_frame", "The history's last frame that was seen, held.", at_least(0)), h.last_frame);
  std::vector<HeldOutCapture> several;
  std::string shown;
  if (h.captures.size() == 1)
    shown = h.captures.front().shown;
  else
    several = h.captures;
  v.member(
      if_set("shown",
             "Time of the pictures in the folder `held_out`, with its unit; of several histories each has its own."),
      shown);
  v.member(if_set("captures", "Of several histories: each by itself. The objectives above are their means."), several);
  if (!shown.empty()) several = {{.name = "", .after = h.after, .shown = shown}};
  if (v.is_reading()) h.captures = several;
}

void describe(DocumentVisitor& v, FittedNumber& n) {
  std::array<double, 2> range{n.low, n.high};
  v.member({"pointer", "JSON pointer into the scene."}, n.pointer);
  v.member({.name = "name",
            .help = "What the scene calls it: \"rule patina: rate\"; the pointer where it has no words for it.",
            .presence = Presence::Optional},
           n.words);
  v.member({.name = "unit",
            .help = "\"per h\" of a rate of a rule, \"layers\" of an amount; empty where it has none.",
            .presence = Presence::Optional},
           n.unit);
  v.member({"range"}, range);
  n.low = range[0], n.high = range[1];
  v.choice({"scale"}, n.scale, kFitScaleNames);
  v.member({"needs_aging"}, n.needs_aging);
  v.member({"initial"}, n.initial);
  v.member({"best"}, n.best);
  v.member({"interval", "Values that the figures cannot tell from the best."}, n.interval);
  v.choice({"determination"}, n.found.determination, kDeterminationNames);
  v.member({"effect", "Largest change of the objective along the range, the others held.", at_least(0)},
           n.found.effect);
  v.member({"verdict"}, n.verdict);
  v.member(if_set("capture", "Whose own number it is; absent: all captures share it."), n.capture);
  if (n.words.empty()) n.words = n.name();
}

void describe(DocumentVisitor& v, FigureChange& c) {
  v.member({"name"}, c.before.name);
  v.member({"title"}, c.before.title);
  v.member({"unit"}, c.before.unit);
  v.member(or_null("before"), c.before.value);
  v.member(or_null("after"), c.after);
  v.member(or_null("split"), c.before.split);
  v.member(if_set("capture", "Where there are several."), c.capture);
}

void describe(DocumentVisitor& v, FittedCapture& c) {
  v.member({"name"}, c.name);
  v.member({"history"}, c.history);
  v.member({"key"}, c.key);
  v.member(or_null("before"), c.before);
  v.member(or_null("after"), c.after);
}

void describe(DocumentVisitor& v, FitManifest& m) {
  v.member({"model", "Name of the scene."}, m.model);
  v.object({"history"}, true, [&] {
    v.member({"name"}, m.history);
    v.member({"key"}, m.history_key);
  });
  v.object({"objective"}, true, [&] {
    v.member(or_null("before", "With the starting values.", at_least(0)), m.objective_before);
    v.member({"after", "", at_least(0)}, m.objective_after);
    v.member({.name = "terms", .min_size = 1}, m.terms);
    v.member({.name = "other_seeds",
              .help = "The best values with other seeds of the simulation, against the history.",
              .has_nulls = true},
             m.other_seeds);
    v.member({"chance",
              "The simulation against itself with another seed in the history's place: at the best values, and at "
              "those near it.",
              at_least(0)},
             m.chances);
    v.member({"threshold", "Rises of the objective over the best up to here mean nothing.", at_least(0)}, m.threshold);
  });
  v.member({.name = "held_out",
            .help = "With `until`: objectives of the compared times after it, which the search did not see.",
            .presence = Presence::Optional,
            .is_nullable = true},
           m.held_out);
  v.member({.name = "parameters", .min_size = 1, .max_size = 100}, m.numbers);
  v.member(or_null("correlation",
                   "Of the errors of two parameters, by their order; near +-1, only a combination of them is "
                   "determined.",
                   between(-1.000001, 1.000001)),
           m.correlation);
  v.member({"no_correlation", "Why there is none."}, m.no_correlation);
  v.object({"evaluations"}, true, [&] {
    v.member({"planned", "", at_least(1)}, m.num_planned);
    v.member({"agings", "Of each capture.", at_least(1)}, m.num_agings);
    v.member({"appearance_evaluations", "", at_least(1)}, m.num_points);
    v.member({"converged"}, m.is_converged);
    v.member(or_null("lately_gained",
                     "By how much the last 8 + 2 n generations of the best descent brought the objective down."),
             m.lately_gained);
  });
  v.member({"figures", "Of a comparison, A the history, B the simulation."}, m.figures);
  describe_origin(v, m.origin);
  v.member(if_set("captures",
                  "Where several histories were fitted at once, the objective being the mean of theirs: `history` has "
                  "all names and keys then."),
           m.captures);
}

FitManifest read_fit_manifest(const fs::path& path) {
  const fs::path file = manifest_folder(path, kFitReportFile) / kFitReportFile;
  Json root = load_json(file);
  update_spelling(root, 1,
                  {{"ageings", "agings"}, {"needs_ageing", "needs_aging"}, {"looks", "appearance_evaluations"}});
  FitManifest m;
  read_document(kFitDocument, file, root, described(m));
  return m;
}

Json fit_schema() { return document_schema(kFitDocument, described<FitManifest>()); }

}  // namespace patinate::analysis
