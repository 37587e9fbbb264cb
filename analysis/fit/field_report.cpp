#include "analysis/fit/field_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/fit/held_out_report.h"
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

Json misfit_json(const FieldMisfit& m) {
  return Json{{"by_place", m.by_place}, {"color_distribution", optional_json(m.color_distribution)}};
}
Json misfits_json(const FieldMisfits& m) {
  return Json{{"seen", misfit_json(m.seen)}, {"held_out", m.held_out ? misfit_json(*m.held_out) : Json(nullptr)}};
}

Json field_json(const FieldTask& task, const FieldOutcome& o, std::size_t i) {
  const FitParameter& p = task.parameters[i];
  const FoundField& f = o.fields[i];
  Json trials = Json::array();
  for (const SmoothnessTrial& t : f.fitted.trials)
    trials.push_back({{"smoothness", optional_json(t.smoothness)}, {"left_out", t.left_out}});
  return Json{
      {"pointer", p.range.name},
      {"name", shown_name(p)},
      {"unit", p.unit},
      {"range", {p.range.low, p.range.high}},
      {"scale", kFitScaleNames[static_cast<std::size_t>(p.range.scale)]},
      {"before", p.start},
      {"single", f.single},
      {"low", f.low},
      {"high", f.high},
      {"waves", f.fitted.field.num_waves},
      {"coefficients", f.fitted.field.coefficients},
      {"effective_numbers", f.fitted.num_effective},
      {"smoothness", optional_json(f.fitted.smoothness)},
      {"trials", trials},
      {"explained_seen", f.without ? optional_json(explained_at(o.after, *f.without, false)) : Json(nullptr)},
      {"explained_held_out", f.without ? optional_json(explained_at(o.after, *f.without, true)) : Json(nullptr)}};
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

}  // namespace

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

  Json fields = Json::array(), options = Json::object();
  for (std::size_t i = 0; i < o.fields.size(); ++i) fields.push_back(field_json(task, o, i));
  for (const auto& [name, value] : option_values(task.options)) options[name] = value;
  save_json(folder / kFieldReportFile,
            Json{{"format", "patinate.field"},
                 {"version", 1},
                 {"model", task.model_name},
                 {"history", {{"name", file.series.name()}, {"key", file.key()}}},
                 {"times", {{"seen", o.num_times_seen}, {"held_out", o.num_times_held_out}, {"unit", o.time_unit}}},
                 {"before", misfits_json(o.before)},
                 {"single", misfits_json(o.single)},
                 {"after", misfits_json(o.after)},
                 {"last_frame", optional_json(o.last_frame)},
                 {"explained_seen", optional_json(explained_at(o.after, o.single, false))},
                 {"explained_held_out", optional_json(explained_at(o.after, o.single, true))},
                 {"fields", fields},
                 {"simulations", o.num_simulations},
                 {"options", options},
                 {"command", task.command},
                 {"key", key}});
}

}  // namespace patinate::analysis
