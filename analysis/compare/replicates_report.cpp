#include "analysis/compare/replicates_report.h"

#include <nlohmann/json.hpp>

#include "analysis/compare/compare_job.h"
#include "analysis/compare/compare_report.h"
#include "analysis/compare/replicates_job.h"
#include "analysis/report/report_page.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr double kReportedLevel = 0.05;

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
  const bool are_told_at_once = zeros.size() >= kFewestZeros;
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

Json number_json(const std::optional<double>& v) { return v ? Json(rounded(*v, 9) + 0.0) : Json(nullptr); }

Json figure_json(const ReplicateFigure& f) {
  Json json{{"section", f.what.section}, {"name", f.what.name}, {"title", f.what.title}, {"unit", f.what.unit}};
  if (!f.difference) {
    json["undefined"] = f.what.undefined;
    return json;
  }
  const GroupDifference& d = *f.difference;
  for (const auto& [name, value] :
       {std::pair("between", d.between), std::pair("within_a", d.within_a), std::pair("within_b", d.within_b),
        std::pair("gap", d.gap), std::pair("spread_a", d.spread_a), std::pair("spread_b", d.spread_b),
        std::pair("spread", d.spread), std::pair("p", d.p), std::pair("p_holm", f.p_corrected)})
    json[name] = number_json(value);
  json["effect"] = number_json(d.effect);
  json["effect_a"] = number_json(d.effect_a);
  json["effect_b"] = number_json(d.effect_b);
  return json;
}

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

void write_replicates_report(const fs::path& folder, const ReplicatesProvenance& provenance,
                             const ReplicateComparison& comparison, const Section& look) {
  HtmlPage page(against(comparison.size_a, comparison.size_b) + " replicates");
  page.paragraph(
      "Do A and B differ by more than the replicates of one side differ among themselves? p is the share of the ways "
      "to call " +
      std::to_string(comparison.size_a) + " of all " + std::to_string(comparison.size_a + comparison.size_b) +
      " replicates A that set them at least as far apart (" + std::to_string(comparison.num_labelings) + " " +
      (comparison.is_exact ? "ways, all" : "of them, drawn by chance") + ").");
  for (const std::string& sentence : replicate_verdict(comparison)) {
    std::string text = sentence;
    if (text.front() >= 'a' && text.front() <= 'z' && !text.starts_with("p of"))
      text.front() = static_cast<char>(text.front() - 'a' + 'A');
    page.paragraph(text + ".");
  }
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
  Json figures = Json::array(), a = Json::array(), b = Json::array();
  for (const ReplicateFigure& f : comparison.figures) figures.push_back(figure_json(f));
  for (std::size_t k = 0; k < provenance.files.size(); ++k) {
    Json side = side_json(provenance.files[k]);
    side["name"] = provenance.names[k];
    (k < comparison.size_a ? a : b).push_back(std::move(side));
  }
  Json options = Json::object();
  for (const auto& [name, value] : option_values(provenance.options)) options[name] = value;
  options["seed"] = std::to_string(provenance.options.seed);
  save_json(folder / kCompareReportFile, Json{{"format", "patinate.replicates"},
                                              {"version", 1},
                                              {"a", a},
                                              {"b", b},
                                              {"figures", figures},
                                              {"overall_p", number_json(comparison.overall_p)},
                                              {"labelings", comparison.num_labelings},
                                              {"is_exact", comparison.is_exact},
                                              {"smallest_p", number_json(comparison.smallest_p)},
                                              {"smallest_p_holm", number_json(comparison.smallest_p_corrected)},
                                              {"enough_a_side", comparison.enough_a_side},
                                              {"verdict", replicate_verdict(comparison)},
                                              {"times", provenance.clock},
                                              {"warnings", provenance.warnings},
                                              {"options", options},
                                              {"command", provenance.command},
                                              {"key", provenance.key}});
}

}  // namespace patinate::analysis
