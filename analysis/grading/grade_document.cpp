#include "analysis/grading/grade_document.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/compare/compare_report.h"
#include "analysis/grading/surface_forecast.h"
#include "analysis/report/analysis_documents.h"
#include "libcommon/core/text.h"
#include "libcommon/document/document.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

void describe(DocumentVisitor& v, GivenGrade& g) {
  v.member({"scale"}, g.scale);
  v.member({"grade", "A grade's name, or `not resolved`."}, g.grade);
  v.member({"low", "Of the interval's lower end."}, g.low);
  v.member({"high", "Of its upper end."}, g.high);
}

namespace {

/// Nothing was found, and what the best grade allows could not be seen.
bool is_unresolved(const GradeScale& scale, const GradedFigure& figure, double least) {
  return figure.value == 0.0 && scale.grades.front().up_to > 0.0 && scale.grades.front().up_to < least;
}

/// A figure of a list.
struct NamedFigure {
  std::string name;
  double value = 0.0, low = 0.0, high = 0.0;
};
void describe(DocumentVisitor& v, NamedFigure& f) {
  v.member({"name", "As in the limits file."}, f.name);
  v.member({"value"}, f.value);
  v.member({"low", "In about 90 of 100 cases the truth lies between low and high; equal ends: no interval is known."},
           f.low);
  v.member({"high"}, f.high);
}
struct GradedTime {
  double time = 0.0;
  std::vector<NamedFigure> figures;
  std::vector<GivenGrade> grades;
  std::string distribution;
  int num_spots = 0;
  std::optional<double> mean_spot_mm;
};
void describe(DocumentVisitor& v, GradedTime& t) {
  v.member({"time"}, t.time);
  v.member({"figures"}, t.figures);
  v.member({"grades"}, t.grades);
  v.member({"distribution", "Of rust, ASTM D610: S, G, P, H, or empty."}, t.distribution);
  v.member({"spots", "", at_least(0)}, t.num_spots);
  v.member({.name = "mean_spot_mm", .help = "Diameter of a circle of the same area.", .is_nullable = true},
           t.mean_spot_mm);
}

struct ListedGradeTime {
  std::string scale, grade;
  Reached state = Reached::NotReached;
  std::optional<double> time, earliest, latest;
};
void describe(DocumentVisitor& v, ListedGradeTime& g) {
  v.member({"scale"}, g.scale);
  v.member({"grade"}, g.grade);
  v.choice({"state"}, g.state, kReachedNames);
  v.member({.name = "time", .is_nullable = true}, g.time);
  v.member({.name = "earliest", .is_nullable = true}, g.earliest);
  v.member({.name = "latest", .is_nullable = true}, g.latest);
}

struct ForecastTime {
  double time = 0.0, value = 0.0, low = 0.0, high = 0.0;
};
void describe(DocumentVisitor& v, ForecastTime& f) {
  v.member({"time"}, f.time);
  v.member({"value"}, f.value);
  v.member({"low", "The figure will lie between low and high in about 90 of 100 cases."}, f.low);
  v.member({"high"}, f.high);
}
struct ListedForecast {
  std::string figure;
  GrowthTest test;
  std::vector<ForecastTime> times;
};
void describe(DocumentVisitor& v, ListedForecast& f) {
  v.member({"figure"}, f.figure);
  v.choice({"law", "How the figure goes on; held: no law foretold it better than its last value."}, f.test.law,
           kGrowthLawNames);
  v.member({"share", "Of the law's further change that the series followed in tests.", between(0, 1)}, f.test.share);
  v.member({"error", "Root mean square error of the tests, over the range of the series.", at_least(0)}, f.test.error);
  v.member({"held_error", "The same of the last value held.", at_least(0)}, f.test.held_error);
  v.member({"times"}, f.times);
}

struct ListedRegion {
  std::string name;
  std::int64_t num_pixels = 0;
  std::optional<double> area_mm2;
  double seen_from_percent = 0.0;
  std::vector<GradedTime> times;
  std::vector<ListedGradeTime> reached;
  std::vector<ListedForecast> forecasts;
};
void describe(DocumentVisitor& v, ListedRegion& r) {
  v.member({"name"}, r.name);
  v.member({"pixels", "", at_least(1)}, r.num_pixels);
  v.member({.name = "area_mm2", .is_nullable = true}, r.area_mm2);
  v.member({"seen_from_percent", "Share of the smallest spot that is counted."}, r.seen_from_percent);
  v.member({"times"}, r.times);
  v.member({"reached", "When grades were reached."}, r.reached);
  v.member({"forecasts", "Of figures after the last photograph, where asked for."}, r.forecasts);
}

struct ListedLimit {
  std::string text, region, found;
  LimitState state = LimitState::Undecided;
};
void describe(DocumentVisitor& v, ListedLimit& l) {
  v.member({"limit", "As it stands in the limits file."}, l.text);
  v.member({"region"}, l.region);
  v.choice({"state"}, l.state, kLimitStateNames);
  v.member({"found"}, l.found);
}

struct ListedScale {
  std::string name, title, standard;
  bool is_checked = false;
};
void describe(DocumentVisitor& v, ListedScale& s) {
  v.member({"name"}, s.name);
  v.member({"title"}, s.title);
  v.member({"standard", "With edition and clause."}, s.standard);
  v.member({"checked", "Somebody compared its limits with the standard's text."}, s.is_checked);
}

}  // namespace

void describe(DocumentVisitor& v, Scribe& s) {
  v.member({"x0", "Of one end, mm from the upper left corner."}, s.x0);
  v.member({"y0"}, s.y0);
  v.member({"x1", "Of the other end."}, s.x1);
  v.member({"y1"}, s.y1);
  v.member({"width_mm", "", at_least(0)}, s.width_mm);
}

namespace {

struct GradeDocument {
  ComparedSide history;
  std::vector<SampleFact> sample;
  double edge_mm = 0.0;
  std::optional<double> unexposed_time;
  std::vector<Scribe> scribes;
  std::vector<ListedRegion> regions = {};
  std::vector<ListedLimit> limits = {};
  std::vector<ListedScale> scales = {};
  std::vector<std::string> summary, notes;
  std::string command, key;
};
void describe(DocumentVisitor& v, GradeDocument& d) {
  v.member({"history"}, d.history);
  v.list({.name = "sample", .help = "What the project says of the sample."}, d.sample, [&](SampleFact& fact) {
    v.member({"name"}, fact.name);
    v.member({"text"}, fact.text);
  });
  v.member({"edge_mm", "Band along the edge of the sample that was left out.", at_least(0)}, d.edge_mm);
  v.member({.name = "unexposed_time", .help = "Of what changes are measured from.", .is_nullable = true},
           d.unexposed_time);
  v.member({"scribes", "Scratches from which creep was measured."}, d.scribes);
  v.member({"regions"}, d.regions);
  v.member({"limits"}, d.limits);
  v.member({"scales"}, d.scales);
  v.member({"summary", "A sentence a region, of the last time."}, d.summary);
  v.member({"notes"}, d.notes);
  v.member({"command", "What repeats it."}, d.command);
  v.member({"key", "Content key."}, d.key);
}

constexpr DocumentKind kGradeDocument{.format = "patinate.grade",
                                      .title = "patinate grades",
                                      .about =
                                          "report.json of `patinate grade`: figures and grades of standards by "
                                          "region and time."};

ListedRegion listed(const GradedRegion& region, const GradeReport& report) {
  const auto stated = [](double v) { return rounded(v, 9) + 0.0; };
  const auto stated_if = [&](std::optional<double> v) { return v ? std::optional(stated(*v)) : v; };
  ListedRegion out{region.name, region.num_pixels, stated_if(region.area_mm2), stated(region.seen_from_percent), {}, {},
                   {}};
  for (std::size_t t = 0; t < region.times.size(); ++t) {
    const RegionFigures& figures = region.times[t];
    GradedTime& time = out.times.emplace_back();
    time.time = report.surface.times[t];
    for (const std::string_view name : kGradedFigureNames) {
      if (const std::optional<GradedFigure>& f = figures.figure(name))
        time.figures.push_back({std::string(name), stated(f->value), stated(f->low), stated(f->high)});
    }
    for (const GradeScale& scale : report.rules.scales) {
      if (const auto grade = grade_of(scale, figures, least_of(scale, region))) time.grades.push_back(*grade);
    }
    time.distribution = figures.distribution;
    time.num_spots = figures.num_spots;
    time.mean_spot_mm = stated_if(figures.mean_spot_mm);
  }
  for (const GradeScale& scale : report.rules.scales) {
    const ExtendedSeries series = extended_series(report.surface, region, scale.figure);
    for (const GradeTime& g :
         grade_times(scale, series.times, series.figures, least_of(scale, region), report.surface.times.back()))
      out.reached.push_back({scale.name, scale.grades[g.grade].name, g.state, stated_if(g.time), stated_if(g.earliest),
                             stated_if(g.latest)});
  }
  for (const FigureForecast& f : region.forecasts) {
    ListedForecast& forecast = out.forecasts.emplace_back();
    forecast.figure = f.figure;
    forecast.test = {f.test.law, stated(f.test.share), stated(f.test.error), stated(f.test.held_error)};
    for (std::size_t k = 0; k < f.values.size(); ++k)
      forecast.times.push_back({report.surface.forecast_times[k], stated(f.values[k].value), stated(f.values[k].low),
                                stated(f.values[k].high)});
  }
  return out;
}

}  // namespace

std::optional<GivenGrade> grade_of(const GradeScale& scale, const RegionFigures& figures, double least) {
  const std::optional<GradedFigure>& figure = figures.figure(scale.figure);
  if (!figure) return std::nullopt;
  if (is_unresolved(scale, *figure, least)) return GivenGrade{scale.name, "not resolved", "", ""};
  // The upper end always holds one spot too small to be seen: no damage found is the first grade.
  const auto name = [&](double value) { return scale.grades[grade_index(scale, value)].name; };
  const std::string best = figure->value == 0.0 ? name(0.0) : name(figure->low);
  return GivenGrade{scale.name, name(figure->value), best, figure->value == 0.0 ? best : name(figure->high)};
}

double least_of(const GradeScale& scale, const GradedRegion& region) {
  return scale.figure == "rusted_percent" ? region.seen_from_percent : 0.0;
}

void save_grade_document(const fs::path& folder, const GradeReport& report, const std::vector<std::string>& summary) {
  GradeDocument document{.history = side_of(report.series),
                         .sample = report.series.series.facts().sample,
                         .edge_mm = report.surface.edge_mm,
                         .unexposed_time = report.surface.unexposed_time,
                         .scribes = report.surface.scribes,
                         .summary = summary,
                         .notes = report.surface.notes,
                         .command = report.task.command,
                         .key = report.key};
  for (const GradedRegion& region : report.surface.regions) document.regions.push_back(listed(region, report));
  for (const LimitResult& l : report.limits) document.limits.push_back({l.limit.text, l.region, l.found, l.state});
  for (const GradeScale& s : report.rules.scales)
    document.scales.push_back({s.name, s.title, s.standard + ":" + s.edition + ", " + s.clause, s.is_checked});
  save_json(folder / kGradeReportFile, document_json(kGradeDocument, described(document)));
}

void check_grade_report(const fs::path& file) { check_document<GradeDocument>(kGradeDocument, file); }

Json grade_schema() { return document_schema(kGradeDocument, described<GradeDocument>()); }

}  // namespace patinate::analysis
