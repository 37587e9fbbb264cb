#include "analysis/compare/replicates_report.h"

#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/compare/compare_report.h"
#include "analysis/compare/replicates_job.h"
#include "analysis/report/analysis_documents.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr double kReportedLevel = 0.05;  ///< Significance.

std::string number(double v) { return short_number_text(rounded(v, 3) + 0.0); }
std::string number(const std::optional<double>& v) { return v ? number(*v) : "-"; }

std::string against(std::size_t a, std::size_t b) { return std::to_string(a) + " against " + std::to_string(b); }

void add_replicates(HtmlPage& page, const ReplicatesProvenance& p, std::size_t size_a) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t k = 0; k < p.files.size(); ++k) {
    const TextureSeries& series = p.files[k].series;
    rows.push_back({k < size_a ? "A" : "B", p.names[k], series.facts().origin,
                    size_text(series.width(), series.height()), times_text(series.facts()), p.files[k].key()});
  }
  page.heading("What is compared");
  page.table({"side", "replicate", "origin", "pixels", "times", "key"}, rows);
}

void add_figures(HtmlPage& page, const ReplicateComparison& comparison) {
  std::vector<std::vector<std::string>> rows, undefined;
  std::vector<std::string> zeros;
  const auto is_zero = [](const ReplicateFigure& f) {
    return f.difference && f.difference->between == 0.0 && f.difference->within_a == 0.0 &&
           f.difference->within_b == 0.0;
  };
  for (const ReplicateFigure& f : comparison.figures) {
    if (is_zero(f)) zeros.push_back(f.what.title);
  }
  const bool are_told_at_once = zeros.size() >= kMinZeros;
  for (const ReplicateFigure& f : comparison.figures) {
    if (are_told_at_once && is_zero(f)) continue;
    if (!f.difference) {
      undefined.push_back({f.what.title, f.what.undefined});
      continue;
    }
    const GroupDifference& d = *f.difference;
    rows.push_back({f.what.title + (f.what.unit.empty() ? "" : " (" + f.what.unit + ")"), number(d.between),
                    number(d.within_a), number(d.within_b), number(d.effect), number(d.effect_a), number(d.effect_b),
                    number(d.p), number(f.p_corrected)});
  }
  page.heading("Figures");
  page.paragraph(
      "A to B, within A and within B are root mean square distances of two replicates. The effect is what A to B has "
      "more than the others, in squares, over the standard deviation of one replicate: of both sides, of A, of B.");
  if (are_told_at_once) page.paragraph(zeros_text(zeros, " for every pair of replicates"));
  if (!rows.empty())
    page.table(
        {"figure", "A to B", "within A", "within B", "effect", "in spreads of A", "in spreads of B", "p", "p (Holm)"},
        rows);
  if (undefined.empty()) return;
  page.paragraph("Figures that not every pair has:");
  page.table({"figure", "why"}, undefined);
}

void add_methods_of_replicates(HtmlPage& page) {
  page.heading("Methods");
  page.paragraph(
      "Permutation test on mean squared distances: M. J. Anderson, A new method for non-parametric multivariate "
      "analysis of variance, Austral Ecology 26 (2001) 32-46. Correction for the number of figures: S. Holm, A simple "
      "sequentially rejective multiple test procedure, Scandinavian Journal of Statistics 6 (1979) 65-70. One p for "
      "all figures, from the largest of them: P. H. Westfall, S. S. Young, Resampling-Based Multiple Testing, Wiley "
      "1993. Effect in spreads: J. Cohen, Statistical Power Analysis for the Behavioral Sciences, 2nd ed., 1988.");
}

/// To nine digits, as figures are stated.
void describe_number(DocumentVisitor& v, std::string_view name, std::string_view help, std::optional<double> value,
                     Presence presence = Presence::Required, const Range& range = {}) {
  if (value) value = rounded(*value, 9) + 0.0;
  v.member({.name = name, .help = help, .range = range, .presence = presence, .is_nullable = true}, value);
}

void describe(DocumentVisitor& v, ReplicateFigure& f) {
  v.member({"section"}, f.what.section);
  v.member({"name", "snake_case, unique in the report."}, f.what.name);
  v.member({"title"}, f.what.title);
  v.member({"unit"}, f.what.unit);
  const bool wants_all = v.wants_all() || v.is_reading();
  if (wants_all || !f.difference)
    v.member({"undefined", "Why it has no value; the rest is then missing.", {}, Presence::Optional}, f.what.undefined);
  if (!wants_all && !f.difference) return;
  const GroupDifference d = f.difference.value_or(GroupDifference{});
  const auto number = [&](std::string_view name, std::string_view help, std::optional<double> value) {
    describe_number(v, name, help, value, Presence::Optional);
  };
  number("between", "Root mean square distance of a replicate of A to one of B.", d.between);
  number("within_a", "Of two of A.", d.within_a);
  number("within_b", "Of two of B.", d.within_b);
  number("gap", "What A to B has more than the others, in squares; its root.", d.gap);
  number("spread_a", "Standard deviation of one replicate of A.", d.spread_a);
  number("spread_b", "", d.spread_b);
  number("spread", "Of both sides.", d.spread);
  describe_number(v, "p", "By permutation.", d.p, Presence::Optional, between(0, 1));
  describe_number(v, "p_holm", "Corrected for the number of defined figures.", f.p_corrected, Presence::Optional,
                  between(0, 1));
  number("effect", "The gap in spreads of both sides.", d.effect);
  number("effect_a", "", d.effect_a);
  number("effect_b", "", d.effect_b);
}

/// report.json.
struct ReplicatesDocument {
  std::vector<ComparedSide> a, b;
  ReplicateComparison comparison;
  std::vector<std::string> verdict;
  std::vector<double> clock;
  std::vector<std::string> warnings;
  ReportOrigin origin;
};

void describe(DocumentVisitor& v, ReplicatesDocument& d) {
  ReplicateComparison& c = d.comparison;
  v.member({.name = "a", .help = "Replicates of side A.", .min_size = 2}, d.a);
  v.member({.name = "b", .help = "Replicates of side B.", .min_size = 2}, d.b);
  v.list({"figures"}, c.figures, [&](ReplicateFigure& f) { describe(v, f); });
  describe_number(v, "overall_p", "That no figure differs.", c.overall_p);
  auto labelings = static_cast<std::int64_t>(c.num_labelings), enough = static_cast<std::int64_t>(c.enough_a_side);
  v.member({"labelings", "Ways to call the replicates A and B that were looked at.", at_least(1)}, labelings);
  v.member({"is_exact", "They are all ways."}, c.is_exact);
  describe_number(v, "smallest_p", "That these numbers of replicates can give.", c.smallest_p);
  describe_number(v, "smallest_p_holm", "Of one figure that differs alone.", c.smallest_p_corrected);
  v.member({"enough_a_side", "Replicates a side from which on one figure alone can be below 0.05.", at_least(0)},
           enough);
  v.member({"verdict"}, d.verdict);
  v.member({"times", "At which all are compared, on the clock of the options."}, d.clock);
  v.member({"warnings", "Probable mistakes, one sentence each."}, d.warnings);
  describe_origin(v, d.origin);
}

constexpr DocumentKind kReplicatesDocument{
    .format = "patinate.replicates",
    .title = "patinate comparison of replicates",
    .about =
        "report.json of `patinate history compare A... --against B...`: whether two groups of histories differ by "
        "more than their members do."};

}  // namespace

std::vector<std::string> replicate_verdict(const ReplicateComparison& c) {
  std::vector<std::string> text;
  std::string names;
  std::size_t count = 0;
  for (const ReplicateFigure& f : c.figures) {
    if (!f.difference || f.p_corrected > kReportedLevel) continue;
    names += (count++ == 0 ? "" : ", ") + f.what.name;
  }
  text.push_back("p of all figures together, that none differs: " + number(c.overall_p) + "; the smallest that " +
                 against(c.size_a, c.size_b) + " can give is " + number(c.smallest_p));
  if (c.num_defined == 0) {
    text.push_back("no figure is defined for every pair");
    return text;
  }
  const std::string of = std::to_string(c.num_defined) + (c.num_defined == 1 ? " figure" : " figures");
  text.push_back(count == 0 ? "none of " + of + " differs at 5 %, corrected for their number"
                            : std::to_string(count) + " of " + of + " at 5 %, corrected for their number: " + names);
  if (c.smallest_p_corrected > kReportedLevel)
    text.push_back("one figure alone cannot be below " + number(c.smallest_p_corrected) +
                   " after the correction, however far apart A and B are; " +
                   against(c.enough_a_side, c.enough_a_side) + " replicates could show it");
  return text;
}

std::string verdict_sentence(std::string conclusion) {
  if (conclusion.front() >= 'a' && conclusion.front() <= 'z' && !conclusion.starts_with("p of"))
    conclusion.front() = static_cast<char>(conclusion.front() - 'a' + 'A');
  return conclusion + ".";
}

void write_replicates_report(const fs::path& folder, const ReplicatesProvenance& provenance,
                             const ReplicateComparison& comparison, const Section& look) {
  HtmlPage page(against(comparison.size_a, comparison.size_b) + " replicates");
  page.paragraph(
      "Do A and B differ by more than the replicates of one side do? p is the share of relabelings (" +
      std::to_string(comparison.size_a) + " of all " + std::to_string(comparison.size_a + comparison.size_b) +
      " replicates called A) that separate the sides at least as much (" + std::to_string(comparison.num_labelings) +
      " relabelings, " + (comparison.is_exact ? "all" : "drawn at random") + ").");
  for (const std::string& conclusion : replicate_verdict(comparison)) page.paragraph(verdict_sentence(conclusion));
  for (const std::string& warning : provenance.warnings) page.paragraph("Warning: " + warning + ".");
  add_figures(page, comparison);
  add_section(page, look, folder, "");
  add_replicates(page, provenance, comparison.size_a);
  add_methods_of_replicates(page);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(provenance.command);
  page.link(kCompareReportFile, "The figures as JSON");
  page.link(kCompareTableFile, "The figures as a table");
  page.link(kReplicateDistancesFile, "The distances of all pairs as a table");
  page.save(folder / kComparePageFile);
  write_atomically(folder / kCompareTableFile, replicate_figures_csv(comparison));
  write_atomically(folder / kReplicateDistancesFile, replicate_distances_csv(comparison, provenance.names));
  ReplicatesDocument document{.a = {},
                              .b = {},
                              .comparison = comparison,
                              .verdict = replicate_verdict(comparison),
                              .clock = provenance.clock,
                              .warnings = provenance.warnings,
                              .origin = {with_seed(option_values(provenance.options), provenance.options.seed),
                                         provenance.command, provenance.key}};
  for (std::size_t k = 0; k < provenance.files.size(); ++k) {
    ComparedSide side = side_of(provenance.files[k]);
    side.name = provenance.names[k];
    (k < comparison.size_a ? document.a : document.b).push_back(std::move(side));
  }
  save_json(folder / kCompareReportFile, document_json(kReplicatesDocument, described(document)));
}

void check_replicates_report(const std::filesystem::path& file) {
  check_document<ReplicatesDocument>(kReplicatesDocument, file);
}

Json replicates_schema() { return document_schema(kReplicatesDocument, described<ReplicatesDocument>()); }

}  // namespace patinate::analysis
