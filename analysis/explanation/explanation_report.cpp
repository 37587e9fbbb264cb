#include "analysis/explanation/explanation_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "analysis/report/analysis_documents.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"
#include "libcommon/output/svg_chart.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr int kDigits = 6;           ///< Significant, of figures in files.
constexpr std::size_t kTenths = 10;  ///< Parts of the surface in the chart.
constexpr std::size_t kCharted = 3;  ///< Controls in the chart.

double stated(double v) { return rounded(v, kDigits) + 0.0; }
std::string hundredths(double v) { return short_number_text(std::round(100.0 * v) / 100.0 + 0.0); }
std::string interval(const ExplanationFigures& f) {
  return f.low && f.high ? "[" + hundredths(*f.low) + ", " + hundredths(*f.high) + "]" : "-";
}
std::string p_text(double p) { return short_number_text(rounded(p, 2)); }

std::string correlation_text(const ExplanationFigures& f) {
  std::string text = hundredths(f.correlation);
  if (f.low && f.high) text += " (95 %: " + hundredths(*f.low) + " to " + hundredths(*f.high) + ")";
  return text;
}

std::string control_argument(const ExplanationReport& report) {
  std::string text = "--control '" + report.found.mix.expression + "'";
  std::set<std::string> given;
  for (const MixMember& m : report.found.mix.members) {
    const auto control = std::find_if(report.task.controls.begin(), report.task.controls.end(),
                                      [&](const auto& c) { return c.name == report.controls[m.candidate].name; });
    for (const std::string& option : control->options) text += given.insert(option).second ? option : "";
  }
  return text;
}

/// What a reader should know before believing it.
std::vector<std::string> notes_of(const ExplanationReport& report) {
  std::vector<std::string> notes = report.task.reference.notes;
  const Explanation& found = report.found;
  if (found.is_coarse)
    notes.push_back("blocks of " + short_number_text(rounded(found.block_mm, 3)) +
                    " mm are too small for a reference that is correlated over " +
                    short_number_text(rounded(found.range_mm, 3)) +
                    " mm (2.5 times as much is needed): intervals are too narrow; p values were raised to compensate");
  return notes;
}

void write_table(const fs::path& file, const ExplanationReport& report) {
  std::string text = "control,correlation,low,high,shuffled_low,shuffled_high,p,corrected_p,explains\n";
  const auto add = [&](const std::string& name, const ExplanationFigures& f, bool is_mix) {
    const auto number = [](double v) { return number_text(stated(v)); };
    std::string quoted = name;
    if (quoted.find_first_of(",\"") != std::string::npos) {
      for (std::size_t i = 0; (i = quoted.find('"', i)) != std::string::npos; i += 2) quoted.insert(i, 1, '"');
      quoted = '"' + quoted + '"';
    }
    text += quoted + "," + number(f.correlation) + "," + (f.low ? number(*f.low) : "") + "," +
            (f.high ? number(*f.high) : "") + ",";
    text += is_mix ? "," : number(f.shuffled_low) + "," + number(f.shuffled_high);
    text += "," + number(f.p) + "," + (is_mix ? "" : number(f.corrected_p)) + "," + (f.explains ? "1" : "0") + "\n";
  };
  for (const ExplainedCandidate& c : report.found.candidates) {
    if (!c.is_even) add(c.name, c.figures, false);
  }
  if (report.found.mix.members.size() > 1) add(report.found.mix.expression, report.found.mix.figures, true);
  write_atomically(file, text);
}

/// Mean rank of the reference in each tenth of the surface by a control, both in [0, 1].
ChartSeries tenths(const std::string& name, const std::vector<double>& values, bool is_inverse,
                   const std::vector<double>& reference) {
  const auto order_of = [](const std::vector<double>& list) {
    std::vector<std::size_t> order(list.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return list[i] < list[j]; });
    return order;
  };
  const auto n = static_cast<double>(values.size());
  std::vector<double> rank(values.size());
  const std::vector<std::size_t> by_reference = order_of(reference);
  for (std::size_t i = 0; i < rank.size(); ++i) rank[by_reference[i]] = (static_cast<double>(i) + 0.5) / n;
  std::vector<double> sum(kTenths), count(kTenths);
  const std::vector<std::size_t> order = order_of(values);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t tenth = i * kTenths / order.size(), at = is_inverse ? kTenths - 1 - tenth : tenth;
    sum[at] += rank[order[i]];
    count[at] += 1.0;
  }
  ChartSeries series{.name = (is_inverse ? "!" : "") + name};
  for (std::size_t k = 0; k < kTenths; ++k) {
    series.x.push_back((static_cast<double>(k) + 0.5) / kTenths);
    series.y.emplace_back(count[k] > 0.0 ? std::optional(sum[k] / count[k]) : std::nullopt);
  }
  return series;
}

std::string tenths_chart(const ExplanationReport& report) {
  Chart chart{.title = "Not only a line?", .x_label = "rank of the control", .y_label = "mean rank of the reference"};
  for (const ExplainedCandidate& c : report.found.candidates) {
    if (c.is_even || chart.series.size() >= kCharted) break;
    const auto at = std::find_if(report.input.candidates.begin(), report.input.candidates.end(),
                                 [&](const ExplanationCandidate& other) { return other.name == c.name; });
    chart.series.push_back(tenths(c.name, at->values, c.figures.correlation < 0.0, report.input.reference));
  }
  return svg_chart(chart);
}

void add_candidates(HtmlPage& page, const ExplanationReport& report) {
  const Explanation& found = report.found;
  page.heading("How far the reference follows each control");
  std::vector<std::vector<std::string>> rows;
  std::string even;
  for (const ExplainedCandidate& c : found.candidates) {
    if (c.is_even) even += (even.empty() ? "" : ", ") + c.name;
    if (c.is_even) continue;
    const ExplanationFigures& f = c.figures;
    rows.push_back({c.name, hundredths(f.correlation), interval(f), f.correlation < 0.0 ? "low" : "high",
                    "[" + hundredths(f.shuffled_low) + ", " + hundredths(f.shuffled_high) + "]", p_text(f.p),
                    p_text(f.corrected_p), f.explains ? "yes" : "no"});
  }
  page.table({"control", "rank correlation", "95 % interval", "aged where it is", "shuffled: middle 95 %", "p",
              "p, corrected", "more than chance"},
             rows);
  const std::string edge = short_number_text(rounded(found.block_mm, 3)) + " mm";
  page.paragraph(
      "Rank correlation [Spearman]: 1 where the reference rises with the control everywhere, -1 where it falls, 0 "
      "where "
      "the two have nothing to do with each other. The squared correlation is about the share of the order that the "
      "control explains. In expressions `!` stands for 1 - control. " +
      std::to_string(report.input.reference.size()) + " places, each for as much of the surface.");
  page.paragraph(
      "Intervals: 95 %, from " + std::to_string(report.task.options.resamples) + " surfaces made of " +
      std::to_string(found.num_blocks) + " blocks of " + edge +
      ", drawn with replacement, because neighboring texels are correlated. Shuffled: the same correlation for " +
      std::to_string(report.task.options.shuffles) +
      " references with permuted blocks. p: the share of these with an equal or stronger correlation, "
      "corrected for " +
      std::to_string(rows.size()) + " controls [Holm]. More than chance: corrected p up to " + number_text(kExplains) +
      ". The reference's values hang together over " + short_number_text(rounded(found.range_mm, 3)) + " mm.");
  if (!even.empty()) page.paragraph("The same everywhere on this surface, so that they explain nothing: " + even + ".");
  for (const MadeControl& s : report.skipped) page.paragraph("Skipped: " + s.name + ": " + s.problem + ".");
}

void add_mix(HtmlPage& page, const ExplanationReport& report) {
  const ExplainedMix& mix = report.found.mix;
  if (mix.members.empty()) return;
  page.heading("The best mix");
  page.code(control_argument(report));
  std::string text = "Rank correlation " + correlation_text(mix.figures) + "; " + hundredths(mix.left_out_correlation) +
                     " on eighths of the surface that the mix has not seen. p = " + p_text(mix.figures.p) +
                     " against the same search on shuffled references: " +
                     (mix.figures.explains ? "more than chance." : "no more than chance gives; do not use it.");
  if (mix.members.size() == 1)
    text +=
        " A further control would explain less than half a percent more of unseen parts, or no more than its error.";
  page.paragraph(text);
  page.paragraph(
      "The line above is what `patinate transfer` takes: it gives the map that the figures are of. Put the name of a "
      "control of the history and `=` before the expression where the history has several.");
}

void write_page(const fs::path& folder, const ExplanationReport& report, const std::vector<Picture>& pictures) {
  const ExplanationTask& task = report.task;
  HtmlPage page("What explains " + task.reference.name + "?");
  page.paragraph(verdict_text(report.found));
  page.paragraph("On " + task.mesh_name + ": " + task.reference.about + ".");
  for (const std::string& note : notes_of(report)) page.paragraph("Note: " + note + ".");
  std::vector<HtmlPicture> shown;
  for (const Picture& p : pictures) shown.push_back({p.source, p.caption});
  page.pictures(shown);
  add_candidates(page, report);
  page.drawing(
      tenths_chart(report),
      "The surface in ten equal parts by each of the strongest controls, from low to high (of `!control`: from "
      "high to low), and the reference's mean rank in each. A hump or a step is more than a correlation "
      "tells.");
  add_mix(page, report);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(task.command);
  page.link(kExplanationFile, "The figures as JSON");
  page.link(kExplanationTableFile, "and as a table");
  page.save(folder / kExplanationPageFile);
}

}  // namespace

std::string verdict_text(const Explanation& found) {
  const auto best = std::find_if(found.candidates.begin(), found.candidates.end(),
                                 [](const ExplainedCandidate& c) { return c.figures.explains; });
  if (found.candidates.empty() || found.candidates.front().is_even)
    return "Nothing can be said: every control is the same everywhere on this surface.";
  std::string text;
  if (best == found.candidates.end()) {
    const ExplainedCandidate& strongest = found.candidates.front();
    text = "No control alone explains it better than chance: the strongest, " + strongest.name +
           ", reaches a correlation of " + correlation_text(strongest.figures) +
           ", p = " + p_text(strongest.figures.corrected_p) + ".";
  } else {
    const bool is_strongest = best == found.candidates.begin();
    text = (is_strongest ? "It follows " : "Of the controls that exceed chance, it follows ") + best->name +
           " best: aged places are where " + best->name + " is " + (best->figures.correlation < 0.0 ? "low" : "high") +
           ", correlation " + correlation_text(best->figures) + ", p = " + p_text(best->figures.corrected_p) + ".";
  }
  if (found.mix.members.size() > 1)
    text += " The mix " + found.mix.expression + " reaches " + correlation_text(found.mix.figures) + ", and " +
            hundredths(found.mix.left_out_correlation) + " on parts that it has not seen: " +
            (found.mix.figures.explains ? "more than chance" : "no more than chance gives") +
            ", p = " + p_text(found.mix.figures.p) + ".";
  return text;
}

namespace {

constexpr DocumentKind kExplanationDocument{
    .format = "patinate.explanation",
    .title = "patinate explanation",
    .about = "explanation.json of `patinate control explain`: the figures of the page beside it."};

/// Numbers are stated().
void describe_number(DocumentVisitor& v, const Member& m, double& value) {
  value = stated(value);
  v.member(m, value);
}

/// Of a candidate or a mix. @param presence  Of its members. @param p  What is said of p.
void describe_figures(DocumentVisitor& v, ExplanationFigures& f, Presence presence, std::string_view p) {
  const Range correlations = between(-1, 1);
  describe_number(v, {"correlation", "Spearman's rank correlation.", correlations, presence}, f.correlation);
  for (const auto& [name, value] : {std::pair("low", &f.low), {"high", &f.high}}) {
    if (*value) *value = stated(**value);
    v.member({name, "End of the 95 % interval; null where blocks are too few.", correlations, presence, true}, *value);
  }
  describe_number(v, {"p", p, between(0, 1), presence}, f.p);
  v.member({.name = "explains", .help = "The corrected p is at most 0.05.", .presence = presence}, f.explains);
}

}  // namespace

void describe(DocumentVisitor& v, ExplanationManifest::Candidate& c) {
  ExplanationFigures& f = c.found.figures;
  std::array<double, 2> range{c.low, c.high}, shuffled{stated(f.shuffled_low), stated(f.shuffled_high)};
  v.member({"name", "As --control takes it."}, c.found.name);
  v.member({"unit"}, c.unit);
  v.member({"range", "What 0 and 1 stand for."}, range);
  c.low = range[0], c.high = range[1];
  v.member({"even", "The same everywhere: it explains nothing, and has no figures."}, c.found.is_even);
  if (c.found.is_even && !v.wants_all()) return;
  const Presence presence = v.wants_all() ? Presence::Optional : Presence::Required;
  describe_figures(v, f, presence, "Share of shuffled references with as strong a correlation.");
  bool is_inverse = f.correlation < 0.0;
  v.member({.name = "inverse", .help = "Aged places are where it is low.", .presence = presence}, is_inverse);
  v.member({"shuffled", "Middle 95 % of shuffled references.", between(-1, 1), presence}, shuffled);
  f.shuffled_low = shuffled[0], f.shuffled_high = shuffled[1];
  describe_number(v, {"corrected_p", "For the number of candidates (Holm).", between(0, 1), presence}, f.corrected_p);
}

void describe(DocumentVisitor& v, ExplanationManifest::Member& m) {
  v.member({"name"}, m.name);
  v.member({"inverse", "1 - value takes part."}, m.found.is_inverse);
  describe_number(v, {"weight", "", between(0, 1)}, m.found.weight);
}

void describe(DocumentVisitor& v, ExplanationManifest::ListedMix& m) {
  v.member({"expression", "As --control of transfer takes it."}, m.found.expression);
  v.member({"argument", "The same with --control and the options that its kinds need."}, m.argument);
  v.member({.name = "members", .min_size = 1, .max_size = 8}, m.members);
  describe_figures(v, m.found.figures, Presence::Required,
                   "Share of shuffled references that the same search explains as well.");
  describe_number(v,
                  {"left_out_correlation", "Of what mixes predict on eighths of the surface that they have not seen.",
                   between(-1, 1)},
                  m.found.left_out_correlation);
}

void describe(DocumentVisitor& v, ExplanationManifest& m) {
  v.member({"reference", "Name of what was explained."}, m.reference);
  v.member({"about", "Its channel, which end counts as aged, the mask, and how much of the surface is known."},
           m.about);
  v.member({"mesh", "Name of the mesh's file."}, m.mesh);
  v.member({"verdict", "One or two sentences: what explains it, or that nothing does."}, m.verdict);
  v.member({"notes", "What to know before believing it."}, m.notes);
  v.member({"places", "Texels looked at, each for as much of the surface.", at_least(500)}, m.num_places);
  describe_number(v, {"area_mm2", "", above(0)}, m.area_mm2);
  v.member({"blocks", "Parts of the surface that intervals and shuffles stand on.", at_least(1)}, m.found.num_blocks);
  describe_number(v, {"block_mm", "Side of a square of a block's mean area.", above(0)}, m.found.block_mm);
  describe_number(
      v,
      {"range_mm", "Distance at which the reference's values no longer know of each other (correlation 0.1).",
       at_least(0)},
      m.found.range_mm);
  v.member({.name = "candidates",
            .help = "The strongest first; those that are the same everywhere last, without figures.",
            .max_size = 1000},
           m.candidates);
  v.list({"skipped", "Kinds without a map."}, m.skipped, [&](std::pair<std::string, std::string>& s) {
    v.member({"name"}, s.first);
    v.member({"reason"}, s.second);
  });
  v.member(or_null("mix", "The best mix of few; null when every candidate is even."), m.mix);
  describe_origin(v, m.origin);
}

void write_explanation(const fs::path& folder, const ExplanationReport& report, const RunControl& control) {
  const ExplanationTask& task = report.task;
  const Explanation& found = report.found;
  fs::create_directories(folder / kJobWorkFolder);
  write_page(folder, report, explanation_pictures(report, folder / kJobWorkFolder / "picture.png", control));
  write_table(folder / kExplanationTableFile, report);
  ExplanationManifest m{.reference = task.reference.name,
                        .about = task.reference.about,
                        .mesh = task.mesh_name,
                        .verdict = verdict_text(found),
                        .notes = notes_of(report),
                        .num_places = report.input.reference.size(),
                        .area_mm2 = report.input.area_mm2,
                        .found = found,
                        .candidates = {},
                        .skipped = {},
                        .mix = {},
                        .origin = {with_seed(option_values(task.options), task.seed), task.command, report.key}};
  for (const ExplainedCandidate& c : found.candidates) {
    const auto made = std::find_if(report.controls.begin(), report.controls.end(),
                                   [&](const MadeControl& known) { return known.name == c.name; });
    m.candidates.push_back({c, made->map.unit, made->map.low, made->map.high});
  }
  for (const MadeControl& s : report.skipped) m.skipped.emplace_back(s.name, s.problem);
  if (!found.mix.members.empty()) m.mix = ExplanationManifest::ListedMix{control_argument(report), {}, found.mix};
  for (const MixMember& member : found.mix.members)
    m.mix->members.push_back({report.controls[member.candidate].name, member});
  save_json(folder / kExplanationFile, document_json(kExplanationDocument, described(m)));
  control.report(1.0);
}

ExplanationManifest read_explanation(const std::filesystem::path& path) {
  ExplanationManifest m;
  read_document(kExplanationDocument, manifest_folder(path, kExplanationFile) / kExplanationFile, described(m));
  return m;
}

Json explanation_schema() { return document_schema(kExplanationDocument, described<ExplanationManifest>()); }

}  // namespace patinate::analysis
