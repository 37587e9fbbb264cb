#include "tools/patinate/command_line/stats.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/figures/aging.h"
#include "analysis/figures/compared_pair.h"
#include "analysis/statistics/history_statistics.h"
#include "app/request/output_file.h"
#include "app/request/path_kind.h"
#include "app/request/usage_error.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_times.h"
#include "libcommon/output/html_page.h"
#include "libcommon/output/svg_chart.h"
#include "patinate/core/error.h"
#include "tools/patinate/command_line/history_warnings.h"

namespace patinate::cli {

namespace {

std::string cell(const std::string& text) { return std::string(text.size() < 10 ? 10 - text.size() : 1, ' ') + text; }
std::string cell(double v) { return cell(short_number_text(rounded(v, 4) + 0.0)); }

Json quartiles_json(const std::optional<analysis::TimeQuartiles>& q, const std::vector<double>& times) {
  if (!q) return Json{{"undefined", "no place ages visibly"}};
  const auto [low, high] = analysis::seen_between(q->median, times);
  return Json{{"q25", q->q25}, {"median", q->median}, {"q75", q->q75}, {"median_seen_between", {low, high}}};
}

std::string quartiles_text(const std::string& name, const std::optional<analysis::TimeQuartiles>& q,
                           const std::vector<double>& times, const std::string& unit) {
  if (!q) return "\n" + name + ": no place ages visibly";
  const auto number = [](double v) { return short_number_text(rounded(v, 4)); };
  const auto [low, high] = analysis::seen_between(q->median, times);
  return "\n" + name + ": median " + (low < high ? "between " + number(low) + " and " + number(high) : number(low)) +
         " " + unit + ", half of the places from " + number(analysis::seen_between(q->q25, times).first) + " to " +
         number(analysis::seen_between(q->q75, times).second);
}

Json json_of(const analysis::HistoryStatistics& s, const std::vector<analysis::ColorClass>& classes,
             const std::string& unit) {
  Json frames = Json::array();
  for (std::size_t t = 0; t < s.times.size(); ++t) {
    Json frame{{"time", s.times[t]},
               {"mean_lab", s.mean_lab[t]},
               {"correlation_length", s.correlation_length[t] ? Json(*s.correlation_length[t]) : Json(nullptr)},
               {"crack_share", s.cracks[t].share},
               {"crack_density", s.cracks[t].density}};
    if (!s.covered.empty()) frame["covered"] = s.covered[t];
    for (std::size_t k = 0; k < classes.size(); ++k) frame["classes"][classes[k].name] = s.class_shares[t][k];
    frames.push_back(std::move(frame));
  }
  return Json{{"kind", "statistics"},
              {"time_unit", unit},
              {"length_unit", s.is_metric ? "mm" : "px"},
              {"frames", frames},
              {"ages_share", s.ages_share},
              {"onset", quartiles_json(s.onset, s.times)},
              {"saturation", quartiles_json(s.saturation, s.times)}};
}

std::string text_of(const analysis::HistoryStatistics& s, const std::vector<analysis::ColorClass>& classes,
                    const std::string& unit) {
  std::string text = cell("time " + unit) + cell("L*") + cell("a*") + cell("b*") + cell("covered") +
                     cell(s.is_metric ? "corr. mm" : "corr. px") + cell(s.is_metric ? "cracks/mm" : "cracks/px");
  for (const analysis::ColorClass& c : classes) text += cell(c.name);
  for (std::size_t t = 0; t < s.times.size(); ++t) {
    text += "\n" + cell(s.times[t]);
    for (double v : s.mean_lab[t]) text += cell(v);
    text += s.covered.empty() ? cell("-") : cell(s.covered[t]);
    text += s.correlation_length[t] ? cell(*s.correlation_length[t]) : cell("-");
    text += cell(s.cracks[t].density);
    for (std::size_t k = 0; k < classes.size(); ++k) text += cell(s.class_shares[t][k]);
  }
  text += "\nages visibly: " + percent_text(s.ages_share) + " of the places";
  return text + quartiles_text("onset", s.onset, s.times, unit) +
         quartiles_text("saturation", s.saturation, s.times, unit);
}

/// One figure of every frame.
struct FrameFigure {
  std::string name;
  std::vector<std::optional<double>> values;
};

template <class ValueAt>
FrameFigure figure(const analysis::HistoryStatistics& s, std::string name, const ValueAt& value_at) {
  FrameFigure out{.name = std::move(name), .values = {}};
  for (std::size_t t = 0; t < s.times.size(); ++t) out.values.push_back(value_at(t));
  return out;
}

std::vector<FrameFigure> color_figures(const analysis::HistoryStatistics& s) {
  std::vector<FrameFigure> figures;
  for (std::size_t c = 0; c < 3; ++c)
    figures.push_back(figure(s, std::string("Lab").substr(c, 1), [&](std::size_t t) { return s.mean_lab[t][c]; }));
  return figures;
}

/// Shares of the surface.
std::vector<FrameFigure> share_figures(const analysis::HistoryStatistics& s,
                                       const std::vector<analysis::ColorClass>& classes) {
  std::vector<FrameFigure> figures;
  if (!s.covered.empty()) figures.push_back(figure(s, "covered", [&](std::size_t t) { return s.covered[t]; }));
  figures.push_back(figure(s, "crack_share", [&](std::size_t t) { return s.cracks[t].share; }));
  for (std::size_t k = 0; k < classes.size(); ++k)
    figures.push_back(figure(s, classes[k].name, [&](std::size_t t) { return s.class_shares[t][k]; }));
  return figures;
}

std::vector<FrameFigure> structure_figures(const analysis::HistoryStatistics& s) {
  const std::string unit = s.is_metric ? "mm" : "px";
  return {figure(s, "crack_density (1/" + unit + ")", [&](std::size_t t) { return s.cracks[t].density; }),
          figure(s, "correlation_length (" + unit + ")", [&](std::size_t t) { return s.correlation_length[t]; })};
}

std::string csv_of(const analysis::HistoryStatistics& s, const std::vector<std::vector<FrameFigure>>& groups,
                   const std::string& unit) {
  std::string text = "time (" + unit + ")";
  for (const auto& group : groups) {
    for (const FrameFigure& f : group) text += "," + f.name;
  }
  for (std::size_t t = 0; t < s.times.size(); ++t) {
    text += "\n" + number_text(s.times[t]);
    for (const auto& group : groups) {
      for (const FrameFigure& f : group) text += "," + (f.values[t] ? number_text(*f.values[t]) : std::string());
    }
  }
  return text + "\n";
}

std::string chart_page(const std::string& title, const analysis::HistoryStatistics& s,
                       const std::vector<std::vector<FrameFigure>>& groups, const std::string& unit) {
  HtmlPage page(title);
  for (const auto& group : groups) {
    std::vector<std::vector<FrameFigure>> charts{group};
    if (&group == &groups.back()) charts = {{group[0]}, {group[1]}};  // Each has a unit of its own.
    for (const auto& figures : charts) {
      Chart chart{.x_label = "time (" + unit + ")", .y_label = figures.size() == 1 ? figures[0].name : ""};
      for (const FrameFigure& f : figures) chart.series.push_back({.name = f.name, .x = s.times, .y = f.values});
      page.drawing(svg_chart(chart));
    }
  }
  return page.text();
}

/// The table, and the same as charts beside it. @returns nothing where no more is to be done.
std::optional<JobStatus> write_stats(CommandRun& run, const std::filesystem::path& file, const std::string& csv,
                                     const std::string& page) {
  const std::filesystem::path charts = std::filesystem::path(file).replace_extension(".html");
  const std::optional<JobStatus> status =
      run.check_files({app::text_file(file, csv), app::text_file(charts, page)}, app::kSameText);
  if (status != JobStatus::Done) return status;
  write_atomically(file, csv);
  write_atomically(charts, page);
  run.note(charts.string() + ": the same as charts");
  return status;
}

}  // namespace

void StatsArgument::declare(CommandLine& line) {
  line.flag("stats",
            "Print statistics of every frame: mean color, covered share, correlation length, onset, saturation",
            is_asked);
  line.repeated("class", "NAME=#RRGGBB", "With --stats: the share of pixels nearest to this color, of those given",
                classes);
  line.option(
      "csv", "FILE.csv",
      "With --stats: color, covered share, cracks and classes of every frame as CSV, and as charts in FILE.html", csv);
  line.written();
}

int report_stats(CommandRun& run, const StatsArgument& stats, const std::filesystem::path& subject) {
  const app::PathKind kind = app::kind_of(subject);
  if (kind != app::PathKind::History && kind != app::PathKind::Transfer)
    throw InvalidInput(subject.string() + ": is no history or transfer, and has no frames");
  if (!stats.csv.empty()) app::require_extension(stats.csv, {".csv"});
  std::vector<analysis::ColorClass> classes;
  for (const std::string& text : stats.classes) {
    try {
      classes.push_back(analysis::parse_color_class(text));
    } catch (const InvalidInput& e) {
      throw app::UsageError(std::string("--class: ") + e.what());
    }
  }
  const analysis::CompareOptions options;
  const analysis::TextureSeries series = analysis::open_series(subject).series;
  const analysis::HistoryStatistics found =
      analysis::history_statistics(series, classes, options.size, options.visible_delta_e, run.control("statistics"));
  const std::string unit = shown_time_unit(series.facts().time_unit);
  if (!stats.csv.empty()) {
    const std::vector<std::vector<FrameFigure>> groups{color_figures(found), share_figures(found, classes),
                                                       structure_figures(found)};
    const auto status = write_stats(run, stats.csv, csv_of(found, groups, unit),
                                    chart_page(subject.filename().string(), found, groups, unit));
    refer_to_history_warnings(run, subject.string(), series.facts().warnings);
    if (status) run.report_output(*status, stats.csv);
    return 0;
  }
  refer_to_history_warnings(run, subject.string(), series.facts().warnings);
  run.report(json_of(found, classes, time_unit_text(series.facts().time_unit)), text_of(found, classes, unit));
  return 0;
}

}  // namespace patinate::cli
