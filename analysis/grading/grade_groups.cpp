#include "analysis/grading/grade_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/compare/replicates.h"
#include "analysis/compare/replicates_report.h"
#include "analysis/grading/grade_report.h"
#include "analysis/grading/grade_rules.h"
#include "analysis/grading/grade_times.h"
#include "analysis/report/analysis_documents.h"
#include "libcommon/core/csv.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/document/document.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kGroupsVersion = 1;  ///< Raised when the same input gives other figures.
const fs::path kPanelsFolder = "panels";
constexpr const char* kGroupsTableFile = "figures.csv";

/// Mean and standard deviation of one figure over the panels of a group.
struct GroupFigure {
  std::vector<double> values = {};
  double mean = 0.0;
  double deviation = 0.0;  ///< Of a panel, with n - 1.
};
void describe(DocumentVisitor& v, GroupFigure& g) {
  v.member({"values", "Of the panels, in order."}, g.values);
  v.member({"mean"}, g.mean);
  v.member({"deviation", "Standard deviation of a panel, with n - 1.", at_least(0)}, g.deviation);
}

struct GroupsFigure {
  std::string region, name;
  GroupFigure a;
  std::optional<GroupFigure> b = {};
  std::optional<double> p = {}, p_corrected = {};
};
void describe(DocumentVisitor& v, GroupsFigure& f) {
  v.member({"region"}, f.region);
  v.member({"name", "As in the limits file."}, f.name);
  v.member({"a"}, f.a);
  v.member({.name = "b", .is_nullable = true}, f.b);
  v.member({.name = "p", .help = "Share of relabelings that separate A and B as much.", .is_nullable = true}, f.p);
  v.member({.name = "p_holm", .help = "Corrected for the number of figures.", .is_nullable = true}, f.p_corrected);
}

struct GroupsGrade {
  std::string region, scale, title;
  std::vector<std::string> a = {}, b = {};
};
void describe(DocumentVisitor& v, GroupsGrade& g) {
  v.member({"region"}, g.region);
  v.member({"scale"}, g.scale);
  v.member({"title"}, g.title);
  v.member({"a", "Grades of the panels, in order."}, g.a);
  v.member({"b"}, g.b);
}

struct GroupPanel {
  std::string name, report, key;
  bool keeps_limits = true;
};
void describe(DocumentVisitor& v, GroupPanel& p) {
  v.member({"name"}, p.name);
  v.member({"report", "Folder of the panel's own report."}, p.report);
  v.member({"keeps_limits", "False if a limit is not kept or could not be tested."}, p.keeps_limits);
  v.member({"key", "Content key."}, p.key);
}

struct GradeGroupsDocument {
  std::vector<GroupPanel> a = {}, b = {};
  double time = 0.0;
  std::vector<GroupsFigure> figures = {};
  std::vector<GroupsGrade> grades = {};
  std::vector<std::string> verdict = {};
  std::string command, key;
};
void describe(DocumentVisitor& v, GradeGroupsDocument& d) {
  v.member({"a"}, d.a);
  v.member({"b", "Empty if one group was graded."}, d.b);
  v.member({"time", "The last one that all panels have."}, d.time);
  v.member({"figures"}, d.figures);
  v.member({"grades"}, d.grades);
  v.member({"verdict", "A sentence each; empty without B."}, d.verdict);
  v.member({"command", "What repeats it."}, d.command);
  v.member({"key", "Content key."}, d.key);
}
constexpr DocumentKind kGroupsDocument{.format = "patinate.grade_groups",
                                       .title = "patinate grades of groups",
                                       .about =
                                           "report.json of `patinate grade A A --against B B`: figures and "
                                           "grades of replicates at the last common time."};

/// A figure of one panel over time, from its report.
struct PanelSeries {
  std::vector<double> times = {};
  std::vector<std::optional<GradedFigure>> figures = {};
};

PanelSeries series_of(const Json& region, const std::string& figure) {
  PanelSeries out;
  for (const Json& time : region.at("times")) {
    out.times.push_back(time.at("time").get<double>());
    out.figures.emplace_back();
    for (const Json& f : time.at("figures")) {
      if (f.at("name") == figure)
        out.figures.back() =
            GradedFigure{f.at("value").get<double>(), f.at("low").get<double>(), f.at("high").get<double>()};
    }
  }
  return out;
}

/// What is known of the panels, by their reports.
struct GradedPanels {
  std::vector<Json> reports;  ///< Those of A first.
  std::size_t size_a = 0;
  double time = 0.0;

  [[nodiscard]] const Json* region(std::size_t panel, const std::string& name) const {
    for (const Json& region : reports[panel].at("regions")) {
      if (region.at("name") == name) return &region;
    }
    return nullptr;
  }
  /// At the common time; nothing where some panel has none.
  [[nodiscard]] std::optional<std::vector<double>> values(const std::string& region_name,
                                                          const std::string& figure) const {
    std::vector<double> out;
    for (std::size_t k = 0; k < reports.size(); ++k) {
      const Json* const of_panel = region(k, region_name);
      if (of_panel == nullptr) return std::nullopt;
      const PanelSeries series = series_of(*of_panel, figure);
      const std::optional<GradedFigure> found = figure_at(series.times, series.figures, time);
      if (!found) return std::nullopt;
      out.push_back(found->value);
    }
    return out;
  }
};

GroupFigure group_figure(std::vector<double> values) {
  GroupFigure out{.values = std::move(values)};
  const auto n = static_cast<double>(out.values.size());
  double squares = 0.0;
  for (const double v : out.values) out.mean += v / n;
  for (const double v : out.values) squares += (v - out.mean) * (v - out.mean);
  out.deviation = std::sqrt(squares / (n - 1.0));
  return out;
}

/// The last time that all panels have. Throws InvalidInput.
double common_time(const std::vector<Json>& reports, const std::vector<std::string>& names) {
  double first = std::numeric_limits<double>::lowest(), last = std::numeric_limits<double>::max();
  std::size_t latest = 0, earliest = 0;
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const Json& times = reports[k].at("regions").at(0).at("times");
    const auto begin = times.front().at("time").get<double>(), end = times.back().at("time").get<double>();
    if (begin > first) first = begin, latest = k;
    if (end < last) last = end, earliest = k;
  }
  if (first > last)
    throw InvalidInput(names[latest] + " begins at " + number_text(first) + ", after the end of " + names[earliest] +
                       " at " + number_text(last) + ": the panels have no time in common");
  return last;
}

/// Adds the figures that every panel has, and tests those that differ anywhere.
std::vector<std::string> add_figures(const GradedPanels& panels, std::uint64_t seed, GradeGroupsDocument& document) {
  const std::size_t count = panels.reports.size(), size_b = count - panels.size_a;
  std::vector<std::vector<PairDistance>> pairs(count * (count - 1) / 2);
  for (const Json& region : panels.reports.front().at("regions")) {
    for (const std::string_view name : kGradedFigureNames) {
      const auto region_name = region.at("name").get<std::string>();
      const std::optional<std::vector<double>> values = panels.values(region_name, std::string(name));
      if (!values) continue;
      const auto middle = values->begin() + static_cast<std::ptrdiff_t>(panels.size_a);
      GroupsFigure figure{
          .region = region_name, .name = std::string(name), .a = group_figure({values->begin(), middle})};
      if (size_b > 0) figure.b = group_figure({middle, values->end()});
      document.figures.push_back(std::move(figure));
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = i + 1; j < count; ++j)
          pairs[pair_index(i, j, count)].push_back({.name = region_name + " " + std::string(name),
                                                    .section = region_name,
                                                    .value = std::abs((*values)[i] - (*values)[j])});
      }
    }
  }
  if (size_b == 0) return {};
  const ReplicateComparison comparison = compare_replicates(pairs, panels.size_a, size_b, seed);
  for (std::size_t k = 0; k < document.figures.size(); ++k) {
    document.figures[k].p = comparison.figures[k].difference->p;
    document.figures[k].p_corrected = comparison.figures[k].p_corrected;
  }
  return replicate_verdict(comparison);
}

void add_grades(const GradeRules& rules, GradeGroupsDocument& document) {
  for (const GroupsFigure& figure : document.figures) {
    for (const GradeScale& scale : rules.scales) {
      if (scale.figure != figure.name) continue;
      GroupsGrade grade{.region = figure.region, .scale = scale.name, .title = scale.title + ", " + scale.standard};
      const auto names = [&](const std::vector<double>& values) {
        std::vector<std::string> out;
        for (const double v : values) out.push_back(scale.grades[grade_index(scale, v)].name);
        return out;
      };
      grade.a = names(figure.a.values);
      if (figure.b) grade.b = names(figure.b->values);
      document.grades.push_back(std::move(grade));
    }
  }
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void write_page(const fs::path& folder, const GradeGroupsDocument& d, const std::string& time) {
  const bool has_b = !d.b.empty();
  HtmlPage page("Grades of " + std::to_string(d.a.size()) +
                (has_b ? " panels against " + std::to_string(d.b.size()) : " panels"));
  page.paragraph("All figures are those at " + time +
                 ", the last time that all panels have. The deviation is that of a single panel.");
  for (const std::string& sentence : d.verdict) page.paragraph(verdict_sentence(sentence));
  std::vector<std::string> header{"region", "figure", "A, mean", "deviation"};
  if (has_b) header.insert(header.end(), {"B, mean", "deviation", "p", "p (Holm)"});
  std::vector<std::vector<std::string>> rows;
  for (const GroupsFigure& f : d.figures) {
    rows.push_back({f.region, figure_title(f.name), figure_text(f.a.mean), figure_text(f.a.deviation)});
    if (f.b)
      rows.back().insert(rows.back().end(), {figure_text(f.b->mean), figure_text(f.b->deviation), figure_text(*f.p),
                                             figure_text(*f.p_corrected)});
  }
  page.table(header, rows);
  page.heading("Grades of the panels");
  rows.clear();
  for (const GroupsGrade& g : d.grades) {
    rows.push_back({g.region, g.title, joined(g.a)});
    if (has_b) rows.back().push_back(joined(g.b));
  }
  page.table(has_b ? std::vector<std::string>{"region", "scale", "A", "B"}
                   : std::vector<std::string>{"region", "scale", "panels"},
             rows);
  page.heading("Panels");
  for (const auto& [side, panels] : {std::pair("A", &d.a), std::pair("B", &d.b)}) {
    for (const GroupPanel& panel : *panels)
      page.link(panel.report + "/" + kGradePageFile, (has_b ? std::string(side) + ": " : "") + panel.name);
  }
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(d.command);
  page.link(kGradeReportFile, "The figures as JSON");
  page.link(kGroupsTableFile, "The figures as a table");
  page.save(folder / kGradePageFile);
}

std::string panel_rows(const GradeGroupsDocument& d) {
  std::string text = "group,panel,region,figure,value\n";
  for (const GroupsFigure& f : d.figures) {
    const auto add = [&](const char* side, const std::vector<GroupPanel>& panels, const GroupFigure& group) {
      for (std::size_t k = 0; k < panels.size(); ++k)
        text += std::string(side) + "," + csv_cell(panels[k].name) + "," + csv_cell(f.region) + "," + f.name + "," +
                csv_cell(std::optional(group.values[k])) + "\n";
    };
    add("A", d.a, f.a);
    if (f.b) add("B", d.b, *f.b);
  }
  return text;
}

std::string panel_folder(std::size_t k) { return (kPanelsFolder / std::to_string(k + 1)).generic_string(); }

JobItem panel_item(JobPlan plan, std::size_t k) {
  const fs::path place = panel_folder(k);
  JobItem item{.name = "panel_" + std::to_string(k + 1),
               .outputs = {place / kGradeReportFile, place / kGradePageFile, place / kGradeTableFile},
               .run = {},
               .key = plan.key};
  item.run = [plan = std::move(plan), place](const fs::path& folder, const RunControl& control) {
    fs::create_directories(folder / place / kJobWorkFolder);  // For pictures on their way into the page.
    plan.join(folder / place, control);
    fs::remove_all(folder / place / fs::path(kJobWorkFolder).parent_path());
  };
  return item;
}

}  // namespace

JobPlan plan_grade_groups(GradeGroupsTask task, const fs::path& output) {
  const std::size_t size_a = task.a.size(), count = size_a + task.b.size();
  if (size_a < 2 || task.b.size() == 1) throw InvalidInput("grade: a group has one panel; replicates are two or more");
  const TimeUnit unit = open_series(task.a.front().history).series.facts().time_unit;
  JobInputs inputs("grade_groups", kGroupsVersion);
  std::vector<JobItem> items;
  for (std::size_t k = 0; k < count; ++k) {
    GradeTask& panel = k < size_a ? task.a[k] : task.b[k - size_a];
    if (open_series(panel.history).series.facts().time_unit != unit)
      throw InvalidInput(task.names[k] + ": its times have another unit than those of " + task.names.front());
    items.push_back(panel_item(plan_grade(panel, output / panel_folder(k)), k));
    for (std::size_t i = 0; i < k; ++i) {
      if (items[i].key == items[k].key)
        throw InvalidInput(task.names[i] + " and " + task.names[k] +
                           " are the same history; every replicate is one of its own");
    }
    inputs.add_content(k < size_a ? "a" : "b", task.names[k], items[k].key);
    inputs.add_value((k < size_a ? "A: " : "B: ") + std::to_string(k), task.names[k]);
  }
  inputs.add_value("--seed", std::to_string(task.seed));
  JobPlan plan = inputs.plan(output, kGradeReportFile);
  plan.parallel_items = false;
  plan.items = std::move(items);
  plan.join = [task = std::move(task), size_a, count, unit, key = plan.key](const fs::path& folder, const RunControl&) {
    GradedPanels panels{.reports = {}, .size_a = size_a};
    GradeGroupsDocument document{.command = task.command, .key = key};
    for (std::size_t k = 0; k < count; ++k) {
      panels.reports.push_back(load_json(folder / panel_folder(k) / kGradeReportFile));
      const Json& limits = panels.reports.back().at("limits");
      const bool keeps = std::none_of(limits.begin(), limits.end(), [](const Json& l) {
        return l.at("state") == "fail" || l.at("state") == "not tested";
      });
      (k < size_a ? document.a : document.b)
          .push_back({task.names[k], panel_folder(k), panels.reports.back().at("key").get<std::string>(), keeps});
    }
    panels.time = document.time = common_time(panels.reports, task.names);
    document.verdict = add_figures(panels, task.seed, document);
    const fs::path& rules = task.a.front().rules;
    add_grades(rules.empty() ? standard_grade_rules() : read_grade_rules(rules), document);
    write_page(folder, document, number_text(document.time) + " " + time_unit_text(unit));
    write_atomically(folder / kGroupsTableFile, panel_rows(document));
    save_json(folder / kGradeReportFile, document_json(kGroupsDocument, described(document)));
  };
  return plan;
}

void check_grade_groups(const fs::path& file) { check_document<GradeGroupsDocument>(kGroupsDocument, file); }

Json grade_groups_schema() { return document_schema(kGroupsDocument, described<GradeGroupsDocument>()); }

}  // namespace patinate::analysis
