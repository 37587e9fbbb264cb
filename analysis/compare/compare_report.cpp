#include "analysis/compare/compare_report.h"

#include <array>
#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/figures/compared_pair.h"
#include "analysis/report/analysis_documents.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_documents.h"
#include "libcommon/history/history_times.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

std::string times_text(const HistoryFacts& m) {
  return std::to_string(m.frames.size()) + " frames, " + short_number_text(m.frames.front().time) + " to " +
         short_number_text(m.frames.back().time) + " " + shown_time_unit(m.time_unit);
}

void describe(DocumentVisitor& v, ComparedSide& s) {
  v.member({"name", "As it was given."}, s.name);
  v.member({"origin", "captured, simulated or synthetic."}, s.origin);
  v.member({"width", "px", at_least(1)}, s.width);
  v.member({"height", "px", at_least(1)}, s.height);
  v.member({"frames", "", at_least(1)}, s.num_frames);
  v.member({"first_time"}, s.first_time);
  v.member({"last_time"}, s.last_time);
  v.choice({"time_unit"}, s.time_unit, kTimeUnitNames);
  v.member(or_null("texel_size_mm"), s.texel_size_mm);
  v.list({"controls"}, s.controls, [&](ControlFacts& c) {
    v.member({"name"}, c.name);
    std::array<double, 2> range{c.low, c.high};
    v.member({"range"}, range);
    c.low = range[0], c.high = range[1];
    v.member({"unit"}, c.unit);
  });
  v.member({"warnings", "Of the history, as its history.json has them."}, s.warnings);
  v.member({"key"}, s.key);
}

ComparedSide side_of(const SeriesFile& side) {
  const TextureSeries& series = side.series;
  const HistoryFacts& m = series.facts();
  return {.name = series.name(),
          .origin = m.origin,
          .width = series.width(),
          .height = series.height(),
          .num_frames = static_cast<std::int64_t>(m.frames.size()),
          .first_time = m.frames.front().time,
          .last_time = m.frames.back().time,
          .time_unit = m.time_unit,
          .texel_size_mm = series.pixel_mm(),
          .controls = m.controls,
          .warnings = m.warnings,
          .key = side.key()};
}

namespace {

void add_provenance(HtmlPage& page, const SeriesFile& a, const SeriesFile& b) {
  std::vector<std::vector<std::string>> rows{{"name"}, {"origin"}, {"pixels"}, {"times"}, {"texel size (mm)"}, {"key"}};
  for (const SeriesFile* side : {&a, &b}) {
    const TextureSeries& series = side->series;
    const std::optional<double> pixel_mm = series.pixel_mm();
    const std::vector<std::string> cells{series.name(),
                                         series.facts().origin,
                                         size_text(series.width(), series.height()),
                                         times_text(series.facts()),
                                         pixel_mm ? short_number_text(*pixel_mm) : "not known",
                                         side->key()};
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back(cells[i]);
  }
  page.table({"", "A", "B"}, rows);
}

/// Adds the warnings of either side's maker: a difference may be that and no aging.
void add_warnings(HtmlPage& page, const SeriesFile& a, const SeriesFile& b) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, side] : {std::pair("A", &a), std::pair("B", &b)}) {
    for (const HistoryWarning& warning : side->series.facts().warnings) rows.push_back({name, warning_text(warning)});
  }
  if (rows.empty()) return;
  page.heading("Warnings of what is compared");
  page.paragraph("Found when the histories were made. A difference below may be one of these and not aging.");
  page.table({"", "warning"}, rows);
}

void add_methods(HtmlPage& page) {
  page.heading("Methods");
  page.paragraph(
      "Color difference: G. Sharma, W. Wu, E. N. Dalal, The CIEDE2000 color-difference formula, Color Research and "
      "Application 30 (2005) 21-30. Structural similarity: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, Image "
      "quality assessment: from error visibility to structural similarity, IEEE Transactions on Image Processing 13 "
      "(2004) 600-612. Distance between distributions of colors: N. Bonneel, J. Rabin, G. Peyre, H. Pfister, Sliced "
      "and Radon Wasserstein barycenters of measures, Journal of Mathematical Imaging and Vision 51 (2015) 22-45. "
      "Best common clock: H. Sakoe, S. Chiba, Dynamic programming algorithm optimization for spoken word recognition, "
      "IEEE Transactions on Acoustics, Speech, and Signal Processing 26 (1978) 43-49. Onset and saturation, on curves "
      "made non-decreasing: M. Ayer, H. D. Brunk, G. M. Ewing, W. T. Reid, E. Silverman, An empirical distribution "
      "function for sampling with incomplete information, Annals of Mathematical Statistics 26 (1955) 641-647. "
      "Spectra: P. D. Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE Transactions "
      "on Audio and Electroacoustics 15 (1967) 70-73. Distance between BRDFs: J. Low, J. Kronander, A. Ynnerman, "
      "J. Unger, BRDF models for accurate and efficient rendering of glossy surfaces, ACM Transactions on Graphics 31 "
      "(2012) 9. Intervals, of blocks drawn anew: H. R. Kunsch, The jackknife and "
      "the bootstrap for general stationary observations, Annals of Statistics 17 (1989) 1217-1241; A. C. Davison, "
      "D. V. Hinkley, Bootstrap Methods and their Application, Cambridge University Press 1997.");
  page.paragraph("docs/algorithms/compare.md of this version says each step.");
}

}  // namespace

namespace {

/// report.json.
struct CompareDocument {
  ComparedSide a, b;
  std::vector<Section> sections;
  std::vector<std::string> warnings;
  ReportOrigin origin;
};

void describe(DocumentVisitor& v, CompareDocument& d) {
  v.member({"a", "What was compared, side A."}, d.a);
  v.member({"b", "What was compared, side B."}, d.b);
  std::vector<ListedFigure> figures = listed_figures(d.sections);
  std::vector<ListedCurve> curves = listed_curves(d.sections);
  v.member({"figures"}, figures);
  describe_undefined_sections(v, d.sections);
  v.member({"warnings", "Probable mistakes, one sentence each."}, d.warnings);
  v.member({"curves", "What is drawn on the page."}, curves);
  describe_origin(v, d.origin);
}

constexpr DocumentKind kCompareDocument{
    .format = "patinate.compare",
    .title = "patinate comparison",
    .about = "report.json of `patinate history compare`: the figures of the page beside it."};

}  // namespace

void write_compare_report(const fs::path& folder, const CompareProvenance& provenance,
                          std::span<const Section> sections) {
  HtmlPage page(provenance.a.series.name() + " against " + provenance.b.series.name());
  page.paragraph(
      "This page compares how two surfaces, A and B, age, at equal times or equal shares of their spans. \"A split in "
      "two\" compares two halves of A, the black and the white squares of a chess board: this is the value for equal "
      "surfaces.");
  add_provenance(page, provenance.a, provenance.b);
  add_warnings(page, provenance.a, provenance.b);
  const std::vector<std::string> warnings =
      pair_warnings(provenance.a.series.facts(), provenance.b.series.facts(), provenance.options);
  for (const std::string& warning : warnings) page.paragraph("Warning: " + warning + ".");
  for (const Section& section : sections) add_section(page, section, folder, "A split in two");
  add_methods(page);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(provenance.command);
  page.link(kCompareReportFile, "The figures as JSON");
  page.link(kCompareTableFile, "The figures as a table");
  page.save(folder / kComparePageFile);
  write_atomically(folder / kCompareTableFile, figures_csv(sections));
  CompareDocument document{.a = side_of(provenance.a),
                           .b = side_of(provenance.b),
                           .sections = {sections.begin(), sections.end()},
                           .warnings = warnings,
                           .origin = {with_seed(option_values(provenance.options), provenance.options.seed),
                                      provenance.command, provenance.key}};
  save_json(folder / kCompareReportFile, document_json(kCompareDocument, described(document)));
}

void check_compare_report(const std::filesystem::path& file) {
  check_document<CompareDocument>(kCompareDocument, file);
}

Json compare_schema() { return document_schema(kCompareDocument, described<CompareDocument>()); }

}  // namespace patinate::analysis
