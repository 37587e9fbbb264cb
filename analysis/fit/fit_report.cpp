#include "analysis/fit/fit_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"
#include "libcommon/output/svg_chart.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr double kStrongCorrelation = 0.8;

std::string number(double v) { return short_number_text(rounded(v, 4) + 0.0); }
std::string number(const std::optional<double>& v) { return v ? number(*v) : "-"; }

const std::string& name_of(const FitTask& task, std::size_t i) { return task.parameters[i].range.name; }

int count_agings(const FitOutcome& o) {
  return static_cast<int>(
      std::count_if(o.searched.begin(), o.searched.end(), [](const FitEvaluation& e) { return !e.points.empty(); }));
}
int count_points(const FitOutcome& o) {
  std::size_t n = 0;
  for (const FitEvaluation& e : o.searched) n += e.points.size();
  return static_cast<int>(n);
}

/// A scan found something better than the search.
bool is_beaten(const FitOutcome& o) {
  for (const BoxScans* lists : {&o.scans, &o.profiles}) {
    for (const std::vector<BoxPoint>& list : *lists) {
      for (const BoxPoint& p : list) {
        if (p.objective < *o.best.result.objective - o.threshold) return true;
      }
    }
  }
  return false;
}

std::string convergence_chart(const FitOutcome& o) {
  Chart chart{.title = "The search", .x_label = "evaluation", .y_label = "objective"};
  ChartSeries each{.name = "tried"}, best{.name = "best so far"};
  std::optional<double> least;
  double x = 0.0;
  // One evaluation: its appearances are what was tried.
  const bool are_appearances = o.searched.size() == 1;
  const auto add = [&](const std::optional<double>& value) {
    if (value) least = least ? std::min(*least, *value) : *value;
    each.x.push_back(x);
    each.y.push_back(value);
    best.x.push_back(x);
    best.y.push_back(least);
    x += 1.0;
  };
  for (const FitEvaluation& e : o.searched) {
    if (e.points.empty()) continue;
    if (are_appearances) {
      for (const FitPoint& p : e.points) add(p.result.objective);
    } else {
      const std::optional<std::size_t> i = e.best();
      add(i ? e.points[*i].result.objective : std::nullopt);
    }
  }
  each.is_dashed = true;
  chart.series = {std::move(best), std::move(each)};
  if (are_appearances) chart.x_label = "appearance";
  return svg_chart(chart);
}

std::string scan_chart(const FitTask& task, const FitOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  Chart chart{
      .title = p.range.name, .x_label = p.range.name, .y_label = "objective", .log_x = p.range.scale == FitScale::Log};
  const auto line_of = [&](const std::string& name, const std::vector<BoxPoint>& list) {
    std::map<double, double> least{{o.best.values[i], *o.best.result.objective}};
    for (const BoxPoint& at : list) {
      const double value = value_at(p, at.at[i]);
      if (std::isfinite(at.objective) && (!least.contains(value) || at.objective < least[value]))
        least[value] = at.objective;
    }
    ChartSeries line{.name = name};
    for (const auto& [value, objective] : least) {
      line.x.push_back(value);
      line.y.emplace_back(objective);
    }
    return line;
  };
  chart.series = {line_of("others as at the best", o.scans[i])};
  if (!o.profiles[i].empty()) chart.series.push_back(line_of("others moved with it", o.profiles[i]));
  ChartSeries limit{.name = "told from the best above", .is_dashed = true};
  for (const double value : chart.series.front().x) {
    limit.x.push_back(value);
    limit.y.emplace_back(*o.best.result.objective + o.threshold);
  }
  chart.series.push_back(std::move(limit));
  return svg_chart(chart);
}

/// Pairs of which only a combination is determined.
std::vector<std::string> correlated_pairs(const FitTask& task, const FitOutcome& o) {
  std::vector<std::string> out;
  if (!o.valley) return out;
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < task.parameters.size(); ++j) {
      const double r = o.valley->correlation[i][j];
      const auto has_effect = [&](std::size_t k) { return o.verdicts[k].effect > o.threshold; };
      if (std::abs(r) < kStrongCorrelation || !has_effect(i) || !has_effect(j)) continue;
      out.push_back(name_of(task, i) + " and " + name_of(task, j) + " make up for each other (" +
                    number(rounded(r, 2)) + "): " +
                    (r > 0 ? "more of one looks like less of the other, so both may be larger or smaller together"
                           : "more of both looks like more of one, so one may be larger and the other smaller") +
                    ".");
    }
  }
  return out;
}

/// A figure of a comparison, and what became of it.
struct FigureChange {
  Figure before;
  std::optional<double> after;
};

std::vector<FigureChange> figure_changes(std::span<const Section> before, std::span<const Section> after) {
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

Json optional_json(const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); }

Json change_json(const FigureChange& change) {
  const Figure& f = change.before;
  return Json{{"name", f.name},
              {"title", f.title},
              {"unit", f.unit},
              {"before", optional_json(f.value)},
              {"after", optional_json(change.after)},
              {"split", optional_json(f.split)}};
}

void add_comparison(HtmlPage& page, const Section& look_before, const Section& look_after,
                    const std::vector<FigureChange>& changes) {
  page.heading("Before and after");
  page.paragraph("The captured surface; the simulated one with the starting values; the simulated one with the best.");
  page.picture({look_before.pictures.at(0).source, "captured"});
  page.picture({look_before.pictures.at(1).source, "simulated, before"});
  page.picture({look_after.pictures.at(1).source, "simulated, after"});
  std::vector<std::vector<std::string>> rows;
  const auto cell = [](const std::optional<double>& v) { return v ? number(*v) : "undefined"; };
  for (const auto& [f, after] : changes)
    rows.push_back({f.title, cell(f.value), cell(after), f.split ? number(*f.split) : "", f.unit});
  page.table({"figure (A captured, B simulated)", "before", "after", "A split in two", "unit"}, rows);
  page.paragraph(
      "\"A split in two\": what equal surfaces would show, the squares of a chess board over the captured one, the "
      "black against the white.");
}

Json parameter_json(const FitTask& task, const FitOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  const ParameterVerdict& v = o.verdicts[i];
  return Json{{"pointer", p.range.name},
              {"range", {p.range.low, p.range.high}},
              {"scale", kFitScaleNames[static_cast<std::size_t>(p.range.scale)]},
              {"needs_aging", !p.is_appearance},
              {"initial", o.initial.values[i]},
              {"best", o.best.values[i]},
              {"interval", {value_at(p, v.low), value_at(p, v.high)}},
              {"determination", kDeterminationNames[static_cast<std::size_t>(v.determination)]},
              {"effect", v.effect},
              {"verdict", verdict_text(task, o, i)}};
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

Json held_out_json(const FitTask& task, const FitOutcome& o) {
  if (!o.held_out) return nullptr;
  Json seeds = Json::array();
  for (const std::optional<double>& v : o.held_out->other_seeds) seeds.push_back(optional_json(v));
  return Json{{"until", *task.objective.until},
              {"times", o.held_out->num_times},
              {"before", optional_json(o.held_out->before)},
              {"after", optional_json(o.held_out->after)},
              {"other_seeds", seeds},
              {"last_frame", optional_json(o.held_out->last_frame)}};
}

void add_held_out(HtmlPage& page, const FitTask& task, const FitOutcome& o) {
  if (!o.held_out) return;
  const HeldOut& h = *o.held_out;
  page.heading("Frames that the search did not see");
  page.paragraph(
      "Only frames up to " + number(*task.objective.until) +
      " were fitted. The objective at the compared times after it (" + std::to_string(h.num_times) +
      " in all) says how well the model foretells; one that is no better than the last frame seen, held, foretells "
      "nothing.");
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const std::optional<double>& v : h.other_seeds) {
    if (v) least = std::min(least, *v), most = std::max(most, *v);
  }
  page.table({"", "objective after " + number(*task.objective.until)},
             {{"starting values", number(h.before)},
              {"best values", number(h.after)},
              {"best values, other seeds", least <= most ? number(least) + " to " + number(most) : "-"},
              {"the last frame seen, held", number(h.last_frame)}});
}

void add_summary(HtmlPage& page, const FitTask& task, const FitOutcome& o) {
  const std::string tried =
      std::to_string(count_agings(o)) + " simulations and " + std::to_string(count_points(o)) + " appearances of them";
  page.paragraph("The objective fell from " + number(o.initial.result.objective) + " to " +
                 number(o.best.result.objective) + " in " + tried + (o.is_converged ? "; the search converged." : "."));
  if (!o.is_converged)
    page.paragraph(
        "Not converged: the budget ended the search, so better values may lie elsewhere, and intervals are those of "
        "what was tried. A larger --evaluations resumes from here.");
  if (is_beaten(o))
    page.paragraph(
        "Not at its end: along one of the parameters there is a better value. A larger --evaluations resumes from "
        "here.");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    const FitParameter& p = task.parameters[i];
    rows.push_back(
        {p.range.name,
         number(p.range.low) + " to " + number(p.range.high) + (p.range.scale == FitScale::Log ? " (log)" : ""),
         number(o.initial.values[i]), number(o.best.values[i]), verdict_text(task, o, i)});
  }
  page.table({"parameter", "range", "before", "best", "what the data say"}, rows);
  page.paragraph(
      "An interval holds the values that the figures cannot tell from the best: the objective rises by no more than " +
      number(o.threshold) + ", " +
      (o.chances.empty()
           ? "a hundredth of the best."
           : "up to what the simulation against itself with another seed stays below in nine of ten cases.") +
      " It holds within this model: a wrong model can be determined as well as a right one.");
  for (const std::string& text : correlated_pairs(task, o)) page.paragraph(text);
  if (!o.no_valley.empty() && task.parameters.size() > 1)
    page.paragraph("Whether parameters make up for each other is not known: " + o.no_valley + ".");
}

}  // namespace

namespace {

std::string interval_text(const FitTask& task, const FitOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  const ParameterVerdict& v = o.verdicts[i];
  const std::string low = number(value_at(p, v.low)), high = number(value_at(p, v.high));
  switch (v.determination) {
    case Determination::Determined:
      return "determined: " + low + " to " + high;
    case Determination::AtLeast:
      return "at least " + low + "; nothing in the range bounds it from above";
    case Determination::AtMost:
      return "at most " + high + "; nothing in the range bounds it from below";
    case Determination::Undetermined:
      return "not determined: the figures cannot tell any two values of its range";
    case Determination::NotExamined:
      return "not known: no evaluations were spent on it (--scan 0)";
    case Determination::WithoutEffect:
      return "not determined: no figure changes anywhere in its range";
  }
  return "";
}

}  // namespace

std::string verdict_text(const FitTask& task, const FitOutcome& o, std::size_t i) {
  return interval_text(task, o, i) + (o.is_converged ? "" : " (not converged)");
}

void write_fit_report(const fs::path& folder, const FitTask& task, const FitOutcome& o, std::span<const Section> before,
                      std::span<const Section> after, const std::string& key) {
  const std::vector<FigureChange> changes = figure_changes(before, after);
  const SeriesFile captured = open_series(task.history);
  const TextureSeries& series = captured.series;
  HtmlPage page(task.model_name + " fitted to " + series.name());
  add_summary(page, task, o);
  page.drawing(convergence_chart(o));
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < task.terms.size(); ++i) {
    const auto which = static_cast<std::size_t>(task.terms[i].figure);
    rows.push_back({std::string(kFitFigureNames[which]), number(task.terms[i].weight),
                    number(o.initial.result.figures[i]), number(o.best.result.figures[i]),
                    std::string(kFitFigureUnits[which])});
  }
  page.table({"fitted figure", "weight", "before", "after", "unit"}, rows);
  add_held_out(page, task, o);
  page.heading("Along each parameter");
  for (std::size_t i = 0; i < task.parameters.size(); ++i) page.drawing(scan_chart(task, o, i));
  add_comparison(page, before.front(), after.front(), changes);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(task.command);
  page.link(kFitReportFile, "The figures as JSON");
  page.link(kFitTableFile, "Everything that was tried, as a table");
  page.save(folder / kFitPageFile);
  write_atomically(folder / kFitTableFile, evaluations_csv(o.searched, task.parameters, task.terms));

  Json parameters = Json::array(), options = Json::object(), figures = Json::array();
  for (const FigureChange& change : changes) figures.push_back(change_json(change));
  for (std::size_t i = 0; i < task.parameters.size(); ++i) parameters.push_back(parameter_json(task, o, i));
  for (const auto& [name, value] : option_values(task.objective)) options[name] = value;
  for (const auto& [name, value] : option_values(task.options)) options[name] = value;
  options["seed"] = std::to_string(task.seed);
  Json correlation = nullptr;
  if (o.valley) correlation = o.valley->correlation;
  save_json(folder / kFitReportFile, Json{{"format", "patinate.fit"},
                                          {"version", 2},
                                          {"model", task.model_name},
                                          {"history", {{"name", series.name()}, {"key", captured.key()}}},
                                          {"objective", objective_json(task, o)},
                                          {"held_out", held_out_json(task, o)},
                                          {"parameters", parameters},
                                          {"correlation", correlation},
                                          {"no_correlation", o.no_valley},
                                          {"evaluations",
                                           {{"planned", o.num_planned},
                                            {"agings", count_agings(o)},
                                            {"appearance_evaluations", count_points(o)},
                                            {"converged", o.is_converged}}},
                                          {"figures", figures},
                                          {"options", options},
                                          {"command", task.command},
                                          {"key", key}});
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
  m.history = json.member("history").member("name").string();
  JsonReader objective = json.member("objective");
  const JsonReader before = objective.member("before");
  m.objective_before = before.is_null() ? 0.0 : before.number(at_least(0));
  m.objective_after = objective.member("after").number(at_least(0));
  for (JsonReader& p : json.member("parameters").elements(100)) {
    m.parameters.push_back(p.member("pointer").string());
    m.verdicts.push_back(p.member("verdict").string());
    m.initial.push_back(p.member("initial").number());
    m.best.push_back(p.member("best").number());
  }
  JsonReader evaluations = json.member("evaluations");
  m.evaluations = static_cast<int>(evaluations.member("agings").integer(at_least(0)));
  m.is_converged = evaluations.member("converged").boolean();
  m.key = json.member("key").string();
  return m;
}

}  // namespace patinate::analysis
