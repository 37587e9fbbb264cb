#include "analysis/fit/fit_report.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/fit/fit_page.h"
#include "analysis/fit/held_out_report.h"
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

constexpr std::string_view kUntilOption = "until";  ///< ObjectiveOptions::until.

Json change_json(const FigureChange& change) {
  const Figure& f = change.before;
  return Json{{"name", f.name},
              {"title", f.title},
              {"unit", f.unit},
              {"before", optional_json(f.value)},
              {"after", optional_json(change.after)},
              {"split", optional_json(f.split)}};
}

Json parameter_json(const FitTask& task, const FitOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  const ParameterVerdict& v = o.verdicts[i];
  Json json{{"pointer", p.range.name},
            {"name", shown_name(p)},
            {"unit", p.unit},
            {"range", {p.range.low, p.range.high}},
            {"scale", kFitScaleNames[static_cast<std::size_t>(p.range.scale)]},
            {"needs_aging", !p.is_appearance},
            {"initial", o.initial.values[i]},
            {"best", o.best.values[i]},
            {"interval", {value_at(p, v.low), value_at(p, v.high)}},
            {"determination", kDeterminationNames[static_cast<std::size_t>(v.determination)]},
            {"effect", v.effect},
            {"verdict", verdict_text(task, o, i)}};
  if (p.capture) json["capture"] = task.captures[*p.capture].name;
  return json;
}

/// Name and key of the history, or of all together.
Json history_json(const std::vector<SeriesFile>& files, const FitTask& task) {
  if (files.size() == 1) return Json{{"name", files.front().series.name()}, {"key", files.front().key()}};
  std::string keys;
  for (const SeriesFile& file : files) keys += (keys.empty() ? "" : " ") + file.key();
  return Json{{"name", captures_text(task)}, {"key", keys}};
}

Json captures_json(const std::vector<SeriesFile>& files, const FitTask& task, const FitOutcome& o) {
  Json list = Json::array();
  for (std::size_t c = 0; c < files.size(); ++c)
    list.push_back({{"name", task.captures[c].name},
                    {"history", files[c].series.name()},
                    {"key", files[c].key()},
                    {"before", optional_json(o.initial.captures[c])},
                    {"after", optional_json(o.best.captures[c])}});
  return list;
}

Json objective_json(const FitTask& task, const FitOutcome& o) {
  Json terms = Json::array(), seeds = Json::array();
  for (std::size_t i = 0; i < task.terms.size(); ++i) {
    const auto which = static_cast<std::size_t>(task.terms[i].figure);
    terms.push_back({{"figure", kFitFigureNames[which]},
                     {"unit", kFitFigureUnits[which]},
                     {"weight", task.terms[i].weight},
                     {"before", optional_json(o.initial.result.figures[i])},
                     {"after", optional_json(o.best.result.figures[i])}});
  }
  for (const FitEvaluation& e : o.seeds) seeds.push_back(optional_json(e.points.front().result.objective));
  return Json{{"before", optional_json(o.initial.result.objective)},
              {"after", *o.best.result.objective},
              {"terms", terms},
              {"other_seeds", seeds},
              {"chance", o.chances},
              {"threshold", o.threshold}};
}

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
  Json parameters = Json::array(), options = Json::object(), figures = Json::array();
  for (std::size_t c = 0; c < captures.size(); ++c) {
    files.push_back(open_series(task.captures[c].history));
    if (are_several) capture_names.push_back(task.captures[c].name);
    changes.push_back(figure_changes(captures[c]));
    for (const FigureChange& change : changes.back()) {
      figures.push_back(change_json(change));
      if (are_several) figures.back()["capture"] = task.captures[c].name;
    }
  }
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    parameters.push_back(parameter_json(task, o, i));
    const std::string& unit = task.parameters[i].unit;
    parameter_names.push_back(column_of(task, i) + (unit.empty() ? "" : " [" + unit + "]"));
  }
  const std::string title =
      task.model_name + " fitted to " + (are_several ? captures_text(task) : files.front().series.name());
  write_fit_page(folder, title, task, o, captures, changes);
  write_atomically(folder / kFitTableFile, evaluations_csv(o.searched, parameter_names, capture_names, task.terms));
  for (const auto& [name, value] : option_values(task.objective)) options[name] = value;
  for (const auto& [name, value] : option_values(task.options)) options[name] = value;
  options["seed"] = std::to_string(task.seed);
  Json correlation = nullptr;
  if (o.valley) correlation = o.valley->correlation;
  Json report{{"format", "patinate.fit"},
              {"version", 2},
              {"model", task.model_name},
              {"history", history_json(files, task)},
              {"objective", objective_json(task, o)},
              {"held_out", held_out_json(task, o)},
              {"parameters", parameters},
              {"correlation", correlation},
              {"no_correlation", o.no_valley},
              {"evaluations",
               {{"planned", o.num_planned},
                {"agings", count_agings(o)},
                {"appearance_evaluations", count_points(o)},
                {"converged", o.is_converged},
                {"lately_gained", optional_json(o.lately_gained)}}},
              {"figures", figures},
              {"options", options},
              {"command", task.command},
              {"key", key}};
  if (are_several) report["captures"] = captures_json(files, task, o);
  save_json(folder / kFitReportFile, report);
}

FitManifest read_fit_manifest(const fs::path& path) {
  const fs::path file = manifest_folder(path, kFitReportFile) / kFitReportFile;
  Json root = load_json(file);
  update_spelling(root, 1,
                  {{"ageings", "agings"}, {"needs_ageing", "needs_aging"}, {"looks", "appearance_evaluations"}});
  JsonReader json(file.string(), root);
  json.expect_format("patinate.fit", 2);
  FitManifest m;
  m.model = json.member("model").string();
  JsonReader history = json.member("history");
  m.history = history.member("name").string();
  m.history_key = history.member("key").string();
  JsonReader objective = json.member("objective");
  for (JsonReader& term : objective.member("terms").elements())
    m.terms.emplace_back(term.member("figure").string(), term.member("weight").number(above(0)));
  JsonReader options = json.member("options");
  for (const auto& [name, value] : option_values(ObjectiveOptions{})) {
    if (name != kUntilOption && options.has(name)) m.comparing.emplace_back(name, options.member(name).string());
  }
  if (json.has("held_out")) m.held_out = read_held_out(json.member("held_out"));
  const JsonReader before = objective.member("before");
  m.objective_before = before.is_null() ? 0.0 : before.number(at_least(0));
  m.objective_after = objective.member("after").number(at_least(0));
  for (JsonReader& p : json.member("parameters").elements(100)) {
    m.parameters.push_back(p.member("pointer").string());
    if (p.has("capture")) m.parameters.back() += " (" + p.member("capture").string() + ")";
    m.words.push_back(p.has("name") ? p.member("name").string() : m.parameters.back());
    m.units.push_back(p.has("unit") ? p.member("unit").string() : "");
    m.verdicts.push_back(p.member("verdict").string());
    m.initial.push_back(p.member("initial").number());
    m.best.push_back(p.member("best").number());
  }
  JsonReader evaluations = json.member("evaluations");
  m.evaluations = static_cast<int>(evaluations.member("agings").integer(at_least(0)));
  m.is_converged = evaluations.member("converged").boolean();
  if (json.has("captures")) m.num_captures = json.member("captures").elements().size();
  m.key = json.member("key").string();
  return m;
}

}  // namespace patinate::analysis
