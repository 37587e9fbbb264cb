#include "analysis/fit/fit_page.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "analysis/fit/fit_charts.h"
#include "analysis/fit/held_out_report.h"
#include "analysis/fit/misfit.h"
#include "libcommon/core/file_name.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"
#include "libcommon/output/svg_chart.h"

namespace patinate::analysis {

namespace {

constexpr double kStrongCorrelation = 0.8;  ///< Correlation of two parameters that is reported.

const std::string& name_of(const FitTask& task, std::size_t i) { return shown_name(task.parameters[i]); }

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

/// Pairs of which only a combination is determined.
std::vector<std::string> correlated_pairs(const FitTask& task, const FitOutcome& o) {
  std::vector<std::string> out;
  if (!o.valley) return out;
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    for (std::size_t j = i + 1; j < task.parameters.size(); ++j) {
      const double r = o.valley->correlation[i][j];
      const auto has_effect = [&](std::size_t k) { return o.verdicts[k].effect > o.threshold; };
      if (std::abs(r) < kStrongCorrelation || !has_effect(i) || !has_effect(j)) continue;
      const std::string both = name_of(task, i) + " and " + name_of(task, j), how_much = figure_text(rounded(r, 2));
      const std::optional<std::size_t> first = task.parameters[i].capture, second = task.parameters[j].capture;
      if (first && second && first != second) {
        out.push_back(both + " are tied through what the captures share (" + how_much + "): " +
                      (r > 0 ? "both may be larger or smaller together" : "one may be larger and the other smaller") +
                      ".");
        continue;
      }
      out.push_back(both + " make up for each other (" + how_much + "): " +
                    (r > 0 ? "more of one looks like less of the other, so both may be larger or smaller together"
                           : "more of both looks like more of one, so one may be larger and the other smaller") +
                    ".");
    }
  }
  return out;
}

/// Those whose best value, or its interval, comes within a hundredth of an end of the range.
std::vector<std::string> at_range_ends(const FitTask& task, const FitOutcome& o) {
  constexpr double kAtEnd = 0.01;  // Share of a range: a parameter nearer to its end lies at it.
  std::vector<std::string> out;
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    const auto is_inside = [](double at) { return at > kAtEnd && at < 1.0 - kAtEnd; };
    const ParameterVerdict& v = o.verdicts[i];
    if (!is_inside(unit_at(task.parameters[i], o.best.values[i]))) {
      out.push_back("The best value of " + name_of(task, i) +
                    " lies at the end of its range: a better one may lie beyond it, so give a wider range if it may.");
    } else if (v.determination == Determination::Determined && !(is_inside(v.low) && is_inside(v.high))) {
      out.push_back("The interval of " + name_of(task, i) +
                    " comes to the end of its range: it may go on beyond, and those of others with it.");
    }
  }
  return out;
}

/// @param of_whom  ": shaded", "" where there is one capture.
void add_comparison(HtmlPage& page, const std::string& of_whom, const Section& look_before, const Section& look_after,
                    const std::vector<FigureChange>& changes) {
  page.heading("Before and after" + of_whom);
  page.paragraph("The captured surface; the simulated one with the starting values; the simulated one with the best.");
  page.picture({look_before.pictures.at(0).source, "captured"});
  page.picture({look_before.pictures.at(1).source, "simulated, before"});
  page.picture({look_after.pictures.at(1).source, "simulated, after"});
  std::vector<std::vector<std::string>> rows;
  const auto cell = [](const std::optional<double>& v) { return v ? figure_text(*v) : "undefined"; };
  for (const auto& [f, after, capture] : changes)
    rows.push_back({f.title, cell(f.value), cell(after), f.split ? figure_text(*f.split) : "", f.unit});
  page.table({"figure (A captured, B simulated)", "before", "after", "A split in two", "unit"}, rows);
  page.paragraph(
      "\"A split in two\": what equal surfaces would show, the squares of a chess board over the captured one, the "
      "black against the white. Halves hold half of a pattern each, so that a whole surface may come nearer.");
}

void add_misfit(HtmlPage& page, const std::string& of_whom, const Section& section) {
  page.heading(section.title + of_whom);
  page.paragraph(
      "Each place of the captured surface by how far its color has to move when the distribution of colors becomes the "
      "simulation's, regardless of position. The mean of the squares is the square of the distance between the "
      "distributions: yellow places make most of it.");
  for (const Picture& p : section.pictures) page.picture({p.source, p.caption});
}

/// By control, A captured and B simulated with the best values.
void draw_curves(const Section& section, const std::function<void(const std::string&, const std::string&)>& draw) {
  for (const Curve& curve : section.curves) {
    Chart chart{.title = curve.title,
                .x_label = curve.x_name,
                .y_label = curve.y_name,
                .from_zero = curve.from_zero,
                .log_x = curve.is_logarithmic,
                .log_y = curve.is_logarithmic};
    for (const CurveColumn& c : curve.columns)
      chart.series.push_back(
          {.name = c.name, .x = curve.x, .y = c.values, .band = c.band, .is_dashed = c.is_reference});
    draw(curve.name, svg_chart(chart));
  }
}

/// How near each of several captures is.
void add_captures(HtmlPage& page, const FitTask& task, const FitOutcome& o) {
  if (task.captures.size() == 1) return;
  std::vector<std::vector<std::string>> rows;
  for (std::size_t c = 0; c < task.captures.size(); ++c)
    rows.push_back({task.captures[c].name, figure_text(o.initial.captures[c]), figure_text(o.best.captures[c]),
                    figure_text(1.0 / static_cast<double>(task.captures.size()))});
  page.heading("Capture by capture");
  page.paragraph(
      "One search for all captures: the objective is the mean of theirs, each of equal weight. Numbers without a "
      "capture's name are shared; each capture has chance of its own, so that what they share is known more closely "
      "than from one of them.");
  page.table({"capture", "objective before", "after", "weight"}, rows);
}

void add_summary(HtmlPage& page, const FitTask& task, const FitOutcome& o) {
  const std::string tried = std::to_string(count_agings(o)) + " simulations " +
                            (task.captures.size() > 1 ? "of each capture " : "") + "and " +
                            std::to_string(count_points(o)) + " appearances of them";
  page.paragraph("The objective fell from " + figure_text(o.initial.result.objective) + " to " +
                 figure_text(o.best.result.objective) + " in " + tried +
                 (o.is_converged ? "; the search converged." : ".") +
                 (o.lately_gained ? " Its last generations lowered it by " + figure_text(*o.lately_gained) +
                                        "; a rise of " + figure_text(o.threshold) + " is within chance."
                                  : ""));
  if (!o.is_converged)
    page.paragraph(
        "Not converged: the budget ended the search, so better values may exist, and intervals cover only the values "
        "that were tried. A larger --evaluations continues the search.");
  if (is_beaten(o))
    page.paragraph(
        "Not at its end: along one of the parameters there is a better value. A larger --evaluations resumes from "
        "here.");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    const FitParameter& p = task.parameters[i];
    rows.push_back({name_of(task, i), p.unit,
                    figure_text(p.range.low) + " to " + figure_text(p.range.high) +
                        (p.range.scale == FitScale::Log ? " (log)" : ""),
                    figure_text(o.initial.values[i]), figure_text(o.best.values[i]), verdict_text(task, o, i)});
  }
  page.table({"parameter", "unit", "range", "before", "best", "what the data say"}, rows);
  const bool is_examined = std::any_of(o.verdicts.begin(), o.verdicts.end(), [](const ParameterVerdict& v) {
    return v.determination != Determination::NotExamined;
  });
  if (is_examined)
    page.paragraph(
        "An interval contains the values that the figures cannot distinguish from the best: the objective rises by no "
        "more than " +
        figure_text(o.threshold) + ". " +
        (o.chances.empty() ? "The limit is a hundredth of the best."
                           : "The limit is the variation by chance, measured by simulations with other seeds in place "
                             "of the capture: all intervals together contain the true values in nine of ten cases.") +
        " This assumes that the model is right; a wrong model can be determined equally well.");
  for (const std::string& text : at_range_ends(task, o)) page.paragraph(text);
  for (const std::string& text : correlated_pairs(task, o)) page.paragraph(text);
  if (!o.no_valley.empty() && task.parameters.size() > 1)
    page.paragraph("It is not known whether parameters compensate for each other: " + o.no_valley + ".");
}

/// Where in the scene file the numbers stand that the page calls by words.
void add_pointers(HtmlPage& page, const FitTask& task) {
  std::vector<std::vector<std::string>> rows;
  for (const FitParameter& p : task.parameters) {
    if (shown_name(p) != p.range.name) rows.push_back({shown_name(p), p.range.name});
  }
  if (rows.empty()) return;
  page.heading("Where the numbers stand in the scene");
  page.table({"parameter", "JSON pointer"}, rows);
}

void add_methods(HtmlPage& page, const FitTask& task, const FitOutcome& o) {
  page.heading("Methods");
  page.paragraph(
      "The objective is the weighted mean of the fitted figures over the compared times, every place counted once. "
      "What needs aging is searched by covariance matrix adaptation [Hansen and Ostermeier 2001; Hansen 2016], from "
      "several of the best points of a space-filling Latin hypercube [McKay, Beckman and Conover 1979; Johnson, Moore "
      "and Ylvisaker 1990]; what only changes the look is searched anew for each aging [as in Golub and Pereyra "
      "1973].");
  page.paragraph(
      "Every simulation of the search has the scene's own seed; " + std::to_string(o.chances.size()) +
      " with other seeds in the capture's place say what chance alone makes of the objective. Frames are "
      "compared at " +
      (o.held_out ? "times up to " + until_text(*task.objective.until, o.held_out->time_unit) : "all compared times") +
      ". docs/algorithms/fit.md of this version says each step.");
  page.paragraph(
      "N. Hansen, A. Ostermeier, Completely derandomized self-adaptation in evolution strategies, Evolutionary "
      "Computation 9(2), 2001. N. Hansen, The CMA evolution strategy: a tutorial, arXiv:1604.00772, 2016. M. McKay, R. "
      "Beckman, W. Conover, A comparison of three methods for selecting values of input variables, Technometrics "
      "21(2), 1979. M. Johnson, L. Moore, D. Ylvisaker, Minimax and maximin distance designs, Journal of Statistical "
      "Planning and Inference 26(2), 1990. G. Golub, V. Pereyra, The differentiation of pseudo-inverses and nonlinear "
      "least squares problems whose variables separate, SIAM Journal on Numerical Analysis 10(2), 1973.");
}

std::string determination_text(const FitTask& task, const FitOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  const ParameterVerdict& v = o.verdicts[i];
  const std::string low = figure_text(value_at(p, v.low)), high = figure_text(value_at(p, v.high));
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
  const bool is_examined = o.verdicts[i].determination != Determination::NotExamined;
  return determination_text(task, o, i) + (o.is_converged || !is_examined ? "" : " (not converged)");
}

void write_fit_page(const std::filesystem::path& folder, const std::string& title, const FitTask& task,
                    const FitOutcome& o, std::span<const CaptureSections> captures,
                    std::span<const std::vector<FigureChange>> changes) {
  HtmlPage page(title);
  const auto draw = [&](const std::string& name, const std::string& svg) {
    std::filesystem::create_directories(folder / kFitDrawingsFolder);
    write_atomically(folder / kFitDrawingsFolder / (name + ".svg"), svg_document(svg));
    page.drawing(svg);
  };
  add_summary(page, task, o);
  draw("search", search_chart(o));
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < task.terms.size(); ++i) {
    const auto which = static_cast<std::size_t>(task.terms[i].figure);
    rows.push_back({std::string(kFitFigureNames[which]), figure_text(task.terms[i].weight),
                    figure_text(o.initial.result.figures[i]), figure_text(o.best.result.figures[i]),
                    std::string(kFitFigureUnits[which])});
  }
  page.table({"fitted figure", "weight", "before", "after", "unit"}, rows);
  add_captures(page, task, o);
  add_held_out(page, task, o);
  const auto is_scanned = [&](std::size_t i) { return o.verdicts[i].determination != Determination::NotExamined; };
  std::vector<std::size_t> scans;
  for (std::size_t i = 0; i < task.parameters.size(); ++i) {
    if (is_scanned(i)) scans.push_back(i);
  }
  if (!scans.empty()) {
    page.heading("Along each parameter");
    page.paragraph(
        "Values where the curve is below the dashed line cannot be distinguished from the best. Where it leaves the "
        "picture, the objective has risen by more than five times as much; the rest is not shown.");
  }
  for (const std::size_t i : scans) {
    std::string name = task.parameters[i].range.name.substr(1);  // A JSON pointer.
    std::replace(name.begin(), name.end(), '/', '_');
    name = "along_" + (is_file_name(name) ? name : std::to_string(i + 1));
    draw(task.parameters[i].capture ? file_of_capture(task.captures.size(), name, *task.parameters[i].capture) : name,
         scan_chart(task, o, i));
  }
  for (std::size_t c = 0; c < captures.size(); ++c) {
    const auto& [before, after] = captures[c];
    const std::string of_whom = captures.size() > 1 ? ": " + task.captures[c].name : "";
    const auto draw_of_capture = [&](const std::string& name, const std::string& svg) {
      draw(file_of_capture(task.captures.size(), name, c), svg);
    };
    add_comparison(page, of_whom, before.front(), after.front(), changes[c]);
    const std::string misfit = misfit_chart("color_distribution", before, after);
    if (!misfit.empty()) draw_of_capture("misfit", misfit);
    if (const std::string text = start_text("color_distribution", before, after); !text.empty()) page.paragraph(text);
    for (const Section& section : after) {
      if (section.name == kMisfitSection) add_misfit(page, of_whom, section);
      if (section.name == "controls" || section.name == "structure") draw_curves(section, draw_of_capture);
    }
  }
  add_pointers(page, task);
  add_methods(page, task, o);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(task.command);
  page.link(kFitReportFile, "The figures as JSON");
  page.link(kFitTableFile, "Everything that was tried, as a table");
  page.save(folder / kFitPageFile);
}

}  // namespace patinate::analysis
