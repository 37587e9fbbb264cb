#include "analysis/fit/field_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/fit/held_out_report.h"
#include "analysis/report/analysis_documents.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"
#include "libcommon/output/svg_chart.h"
#include "patinate/analysis/texture_series.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

std::string percent(const std::optional<double>& v) { return v ? figure_text(rounded(100.0 * *v, 3)) + " %" : "-"; }

std::optional<double> explained_at(const FieldMisfits& with, const FieldMisfits& without, bool is_held_out) {
  if (!is_held_out) return explained_share(with.seen.by_place, without.seen.by_place);
  if (!with.held_out || !without.held_out) return std::nullopt;
  return explained_share(with.held_out->by_place, without.held_out->by_place);
}

void add_misfit_of_fields(HtmlPage& page, const FieldTask& task, const FieldOutcome& o) {
  const bool is_held_out = o.after.held_out.has_value();
  std::vector<std::string> header{"", "by place, seen", "colors, seen"};
  const std::string after = is_held_out ? ", after " + until_text(*task.options.until, o.time_unit) : "";
  if (is_held_out) header.insert(header.end(), {"by place" + after, "colors" + after});
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& name, const FieldMisfits& m) {
    rows.push_back({name, figure_text(m.seen.by_place), figure_text(m.seen.color_distribution)});
    if (is_held_out)
      rows.back().insert(rows.back().end(),
                         {figure_text(m.held_out->by_place), figure_text(m.held_out->color_distribution)});
  };
  add("the scene's own numbers", o.before);
  add("the best numbers for all places", o.single);
  add("fields", o.after);
  for (std::size_t i = 0; i < o.fields.size(); ++i) {
    if (o.fields[i].without) add("fields, but for " + shown_name(task.parameters[i]), *o.fields[i].without);
  }
  if (is_held_out) rows.push_back({"the last frame seen, held", "-", "-", "-", figure_text(o.last_frame)});
  page.heading("How far the model is");
  page.paragraph(
      "Delta E 1976. By place: root mean square over places and times, places being means over the surface at " +
      std::to_string(task.options.places_size) +
      " pixels along the longer side. Colors: distance between the distributions of color, wherever colors lie, as the "
      "objective of a fit. Frames seen are " +
      std::to_string(o.num_times_seen) +
      (is_held_out
           ? "; the " + std::to_string(o.num_times_held_out) + " after them were used for nothing but this table."
           : "."));
  page.table(header, rows);
}

void add_fields(HtmlPage& page, const FieldTask& task, const FieldOutcome& o) {
  page.heading("The fields");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < o.fields.size(); ++i) {
    const FitParameter& p = task.parameters[i];
    const FoundField& f = o.fields[i];
    const bool is_flat = f.fitted.field.num_waves == 1;
    rows.push_back({shown_name(p), p.unit, figure_text(p.range.low) + " to " + figure_text(p.range.high),
                    figure_text(p.start), figure_text(f.single),
                    is_flat ? figure_text(f.low) + " everywhere" : figure_text(f.low) + " to " + figure_text(f.high),
                    std::to_string(f.fitted.field.coefficients.size()),
                    figure_text(rounded(f.fitted.num_effective, 3))});
  }
  page.table({"number", "unit", "range", "before", "best for all places", "field", "numbers", "that the data decide"},
             rows);
  for (std::size_t i = 0; i < o.fields.size(); ++i) {
    if (o.fields[i].fitted.field.num_waves == 1)
      page.paragraph(shown_name(task.parameters[i]) +
                     " stays one number: every field tried was farther from blocks that its search had left out.");
  }
  std::vector<HtmlPicture> maps;
  for (const Picture& p : o.maps) maps.push_back({p.source, p.caption});
  if (!maps.empty()) page.pictures(maps);
  for (std::size_t i = 0; i < o.fields.size(); ++i) {
    Chart chart{.title = "Choice of the smoothness: " + shown_name(task.parameters[i]),
                .x_label = "weight of bending (Delta E^2)",
                .y_label = "Delta E of blocks left out",
                .from_zero = false,
                .log_x = true};
    ChartSeries flat{.name = "one number", .is_dashed = true}, line{.name = "field"};
    const std::vector<SmoothnessTrial>& trials = o.fields[i].fitted.trials;
    for (std::size_t k = 1; k < trials.size(); ++k) {
      flat.x.push_back(*trials[k].smoothness), flat.y.emplace_back(trials[0].left_out);
      line.x.push_back(*trials[k].smoothness), line.y.emplace_back(trials[k].left_out);
    }
    chart.series = {std::move(line), std::move(flat)};
    if (trials.size() > 1) page.drawing(svg_chart(chart));
  }
}

void add_summary_of_fields(HtmlPage& page, const FieldTask& task, const FieldOutcome& o) {
  const auto sentence = [&](bool is_held_out) {
    const double from = is_held_out ? o.single.held_out->by_place : o.single.seen.by_place,
                 to = is_held_out ? o.after.held_out->by_place : o.after.seen.by_place;
    return figure_text(from) + " to " + figure_text(to) + " Delta E (" +
           percent(explained_at(o.after, o.single, is_held_out)) + " of its square)";
  };
  page.paragraph("Place by place the misfit goes from " + sentence(false) +
                 " on the frames seen, when the best numbers for all places become fields" +
                 (o.after.held_out ? ", and from " + sentence(true) + " on those after " +
                                         until_text(*task.options.until, o.time_unit) + ", which no search saw."
                                   : ".") +
                 " It took " + std::to_string(o.num_simulations) + " simulations.");
  page.paragraph(
      "A field says where the model needs more or less of a number to look like the capture. It is a finding about the "
      "material only as far as the model is right: what another layer, light or color would explain ends in the field "
      "as well.");
}

void add_methods_of_fields(HtmlPage& page, const FieldTask& task) {
  page.heading("Methods");
  page.paragraph(
      "A field is a sum of " + std::to_string(task.options.waves) + " x " + std::to_string(task.options.waves) +
      " cosines over the atlas, of the number's logarithm where its range is logarithmic. The model is run with one "
      "value everywhere, " +
      std::to_string(task.options.levels) +
      " times over the range, and each place's colors are read between them; then again near the field that was found. "
      "The sum of squares and a weight times the bending energy of a thin plate is least [Levenberg-Marquardt; Ceres]. "
      "The weight is the one with which blocks of the surface that are left out in turn come nearest [Stone 1974; "
      "Wahba "
      "1990], on the frames seen alone. Numbers that the data decide: the trace of the smoother [Hastie and Tibshirani "
      "1990]. What fields explain is 1 - (misfit with them)^2 / (misfit without)^2.");
  page.paragraph(
      "M. Stone, Cross-validatory choice and assessment of statistical predictions, Journal of the Royal Statistical "
      "Society B 36(2), 1974. G. Wahba, Spline models for observational data, SIAM, 1990. T. Hastie, R. Tibshirani, "
      "Generalized additive models, Chapman and Hall, 1990. S. Agarwal, K. Mierle and others, Ceres Solver.");
}

/// One of FieldTask::parameters and what became of it.
struct ListedField {
  FitParameter parameter;
  FoundField found;
  std::optional<double> explained_seen, explained_held_out;
};

/// report.json.
struct FieldDocument {
  std::string model, history, history_key;
  FieldOutcome found;
  std::optional<double> explained_seen, explained_held_out;
  std::vector<ListedField> fields;
  ReportOrigin origin;
};

constexpr DocumentKind kFieldDocument{
    .format = "patinate.field",
    .title = "patinate fields",
    .about = "report.json of `patinate fit field`: where numbers of a scene differ from place to place."};

void describe(DocumentVisitor& v, ListedField& f) {
  FitParameter& p = f.parameter;
  FittedField& fitted = f.found.fitted;
  std::string name = shown_name(p);
  std::array<double, 2> range{p.range.low, p.range.high};
  v.member({"pointer", "JSON pointer into the scene."}, p.range.name);
  v.member({"name", "What the scene calls it; the pointer where it has no words for it."}, name);
  v.member({"unit", "\"per h\" of a rule's rate; empty where it has none."}, p.unit);
  v.member({"range"}, range);
  v.choice({"scale"}, p.range.scale, kFitScaleNames);
  v.member({"before", "In the scene."}, p.start);
  v.member({"single", "The best for all places."}, f.found.single);
  v.member({"low", "Least value on the surface."}, f.found.low);
  v.member({"high", "Largest."}, f.found.high);
  v.member({"waves", "", between(1, 16)}, fitted.field.num_waves);
  v.member({.name = "coefficients",
            .help = "Of cos(pi i x) cos(pi j y) at j * waves + i, x and y in [0, 1] from the upper left corner: 0 is "
                    "the low end of the range, 1 the high one, logarithmic where the scale is.",
            .min_size = 1},
           fitted.field.coefficients);
  v.member({"effective_numbers", "Numbers that the data decide."}, fitted.num_effective);
  v.member(or_null("smoothness", "Weight of bending; null: one number everywhere."), fitted.smoothness);
  v.member({"trials"}, fitted.trials);
  v.member(or_null("explained_seen",
                   "Of several fields: share of the squared misfit by place that this number, single, leaves and the "
                   "field does not."),
           f.explained_seen);
  v.member(or_null("explained_held_out", "The same on frames held out."), f.explained_held_out);
}

void describe(DocumentVisitor& v, FieldDocument& d) {
  FieldOutcome& o = d.found;
  v.member({"model", "Name of the scene."}, d.model);
  v.object({"history"}, true, [&] {
    v.member({"name"}, d.history);
    v.member({"key"}, d.history_key);
  });
  v.object({"times"}, true, [&] {
    v.member({"seen", "", at_least(1)}, o.num_times_seen);
    v.member({"held_out", "", at_least(0)}, o.num_times_held_out);
    v.member({"unit"}, o.time_unit);
  });
  v.member({"before", "With the scene's own numbers."}, o.before);
  v.member({"single", "With the best numbers for all places."}, o.single);
  v.member({"after", "With the fields."}, o.after);
  v.member(or_null("last_frame", "color_distribution of the last frame seen, held, on the frames held out."),
           o.last_frame);
  v.member(or_null("explained_seen", "1 - (by_place after)^2 / (by_place single)^2."), d.explained_seen);
  v.member(or_null("explained_held_out", "The same on frames held out."), d.explained_held_out);
  v.member({.name = "fields", .min_size = 1}, d.fields);
  v.member({"simulations", "", at_least(1)}, o.num_simulations);
  describe_origin(v, d.origin);
}

}  // namespace

void describe(DocumentVisitor& v, SmoothnessTrial& t) {
  v.member(or_null("smoothness", "Weight of bending; null: one number everywhere."), t.smoothness);
  v.member({"left_out", "Root mean square Delta E of blocks that the search left out.", at_least(0)}, t.left_out);
}

void describe(DocumentVisitor& v, FieldMisfit& m) {
  v.member({"by_place", "Root mean square Delta E 1976 over places and times.", at_least(0)}, m.by_place);
  v.member(or_null("color_distribution", "Distance between the distributions of color, Delta E 1976."),
           m.color_distribution);
}

void describe(DocumentVisitor& v, FieldMisfits& m) {
  v.member({"seen"}, m.seen);
  v.member(or_null("held_out"), m.held_out);
}

std::optional<double> explained_share(double with, double without) {
  if (!(without > 0.0)) return std::nullopt;
  return 1.0 - with * with / (without * without);
}

void write_field_report(const fs::path& folder, const FieldTask& task, const FieldOutcome& o, const std::string& key) {
  const SeriesFile file = open_series(task.history);
  HtmlPage page("Where " + task.model_name + " differs from place to place, by " + file.series.name());
  add_summary_of_fields(page, task, o);
  add_misfit_of_fields(page, task, o);
  add_fields(page, task, o);
  page.heading("Frames");
  for (const Picture& p : o.pictures) page.picture({p.source, p.caption});
  add_methods_of_fields(page, task);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(task.command);
  page.link("scene.json", "The scene with the fields");
  page.link(kFieldReportFile, "The figures as JSON");
  page.save(folder / kFieldPageFile);

  FieldDocument document{.model = task.model_name,
                         .history = file.series.name(),
                         .history_key = file.key(),
                         .found = o,
                         .explained_seen = explained_at(o.after, o.single, false),
                         .explained_held_out = explained_at(o.after, o.single, true),
                         .fields = {},
                         .origin = {option_values(task.options), task.command, key}};
  for (std::size_t i = 0; i < o.fields.size(); ++i) {
    const auto share = [&](bool is_held_out) {
      return o.fields[i].without ? explained_at(o.after, *o.fields[i].without, is_held_out) : std::nullopt;
    };
    document.fields.push_back({task.parameters[i], o.fields[i], share(false), share(true)});
  }
  save_json(folder / kFieldReportFile, document_json(kFieldDocument, described(document)));
}

Json field_schema() { return document_schema(kFieldDocument, described<FieldDocument>()); }

}  // namespace patinate::analysis
