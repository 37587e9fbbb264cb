#include "analysis/fit/fit_ranking_job.h"

#include <algorithm>
#include <cctype>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/fit/fit_ranking.h"
#include "analysis/report/analysis_documents.h"
#include "libcommon/core/csv.h"
#include "libcommon/core/files.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/output/html_page.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kRankingVersion = 6;  ///< Raised when the same fits give other figures.

struct Ranked {
  RankingTask task;
  std::vector<RankedFit> fits;
  Ranking ranking;
};

std::string cell(const Estimate& e) {
  return figure_text(e.value) +
         (e.has_interval() ? " (" + figure_text(*e.low) + " to " + figure_text(*e.high) + ")" : "");
}
std::string cell(const std::optional<Estimate>& e) { return e ? cell(*e) : "-"; }
fs::path folder_of(const RankingTask& task, std::size_t fit) { return manifest_folder(task.fits[fit], kFitReportFile); }

/// Mean over the cases of what searches saw.
double seen(std::span<const RankedFit> fits, const RankedModel& model) {
  double sum = 0.0;
  for (const std::size_t i : model.fits) sum += fits[i].fit.objective_after;
  return sum / static_cast<double>(model.fits.size());
}
bool is_converged(const Ranked& all, const RankedModel& model) {
  return std::all_of(model.fits.begin(), model.fits.end(), [&](std::size_t i) { return all.fits[i].fit.is_converged; });
}
std::size_t num_numbers(std::span<const RankedFit> fits, const RankedModel& model) {
  return fits[model.fits.front()].fit.numbers.size();
}

/// A capture's last held-out frame: captured, and by every model that shows one. @param k  The case.
std::vector<HtmlPicture> pictures_of(const Ranked& all, std::size_t k, std::size_t capture) {
  std::vector<HtmlPicture> pictures;
  for (const RankedModel& m : all.ranking.models) {
    const FitManifest& fit = all.fits[m.fits[k]].fit;
    if (capture >= fit.held_out->captures.size()) continue;
    const HeldOutCapture& held_out = fit.held_out->captures[capture];
    const auto file = [&](const char* stem) {
      return held_out_picture(folder_of(all.task, m.fits[k]), fit.num_captures(), stem, capture);
    };
    if (!fs::exists(file(kHeldOutSimulated))) continue;
    const std::string at = ", " + held_out.shown;
    if (pictures.empty())
      pictures.push_back(
          {data_uri(file(kHeldOutCaptured)), (held_out.name.empty() ? "captured" : held_out.name + ", captured") + at});
    pictures.push_back({data_uri(file(kHeldOutSimulated)), m.name + at + ": " + figure_text(held_out.after)});
  }
  return pictures;
}

/// Adds pictures of each case.
void add_pictures(HtmlPage& page, const Ranked& all) {
  const Ranking& r = all.ranking;
  bool is_first = true;
  for (std::size_t k = 0; k < r.cases.size(); ++k) {
    std::vector<std::vector<HtmlPicture>> rows;
    for (std::size_t c = 0; c < all.fits[r.models.front().fits[k]].fit.num_captures(); ++c) {
      if (std::vector<HtmlPicture> pictures = pictures_of(all, k, c); !pictures.empty())
        rows.push_back(std::move(pictures));
    }
    if (rows.empty()) continue;
    if (std::exchange(is_first, false)) {
      page.heading("The last frame held out");
      page.paragraph(
          "As captured, and as each model has it with its best values; the number is the objective of all held-out "
          "frames of that capture in the case. No search saw a frame after the time of its case.");
    }
    if (r.cases.size() > 1) page.paragraph(case_text(r.cases[k]) + ":");
    for (const std::vector<HtmlPicture>& pictures : rows) page.pictures(pictures);
  }
}

/// With a capital, but where a model's name begins it.
std::string as_sentence(std::string text, const Ranking& ranking) {
  const bool begins_with_name = std::any_of(ranking.models.begin(), ranking.models.end(),
                                            [&](const RankedModel& m) { return text.starts_with(m.name + " "); });
  if (!begins_with_name) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text + ".";
}

/// Adds the parameters that each model varies, and where its fits found them: a row a number, model and case.
void add_numbers(HtmlPage& page, const Ranked& all) {
  const Ranking& r = all.ranking;
  std::vector<std::string> names;
  for (const RankedModel& m : r.models) {
    for (const std::size_t i : m.fits) {
      for (const FittedNumber& number : all.fits[i].fit.numbers) {
        if (std::find(names.begin(), names.end(), number.words) == names.end()) names.push_back(number.words);
      }
    }
  }
  const bool are_several = r.cases.size() > 1;
  std::vector<std::vector<std::string>> rows;
  for (const std::string& name : names) {
    std::string number_cell = name;  // In the first of its rows alone.
    for (const RankedModel& m : r.models) {
      for (std::size_t k = 0; k < m.fits.size(); ++k) {
        const std::vector<FittedNumber>& numbers = all.fits[m.fits[k]].fit.numbers;
        const auto found =
            std::find_if(numbers.begin(), numbers.end(), [&](const FittedNumber& n) { return n.words == name; });
        if (found == numbers.end()) continue;
        std::vector<std::string>& row = rows.emplace_back();
        row = {std::exchange(number_cell, ""), found->unit, m.name};
        if (are_several) row.push_back(case_text(r.cases[k]));
        row.insert(row.end(), {figure_text(found->best), found->verdict});
      }
    }
  }
  std::vector<std::string> header{"number", "unit", "model"};
  if (are_several) header.emplace_back("case");
  header.insert(header.end(), {"best", "what the frames seen say"});
  page.heading("The numbers of the models");
  page.paragraph(
      "Every number that a model varies. One that a model does not vary stands in its scene, if it has one; rules that "
      "the scenes differ in are in the scenes alone.");
  page.table(header, rows);
}

void write_page(const fs::path& folder, const Ranked& all) {
  const Ranking& r = all.ranking;
  HtmlPage page("Which model predicts best?");
  page.paragraph(
      "Each model was fitted to the frames up to a time, and is evaluated on the held-out frames after it. Smaller is "
      "better" +
      (r.unit.empty() ? std::string() : "; the unit is " + r.unit) + ".");
  for (const std::string& sentence : ranking_verdict(r, all.fits)) page.paragraph(as_sentence(sentence, r));
  std::vector<std::vector<std::string>> rows;
  for (const RankedModel& m : r.models)
    rows.push_back({m.name, std::to_string(num_numbers(all.fits, m)), figure_text(seen(all.fits, m)), cell(m.held_out),
                    cell(m.behind), cell(m.beyond_last), is_converged(all, m) ? "yes" : "no"});
  if (r.last_frame) rows.push_back({"holding the last frame", "0", "-", figure_text(*r.last_frame), "-", "-", "-"});
  page.heading("Models");
  const std::string first = r.models.front().name;
  page.table(
      {"model", "parameters", "fitted", "held out", "more than " + first, "more than the last frame", "converged"},
      rows);
  page.paragraph(
      "Parameters: number of varied parameters. Fitted: objective of the fitted frames. Held out: objective of the "
      "later frames, mean over other seeds and over the cases, with a 95 % interval of that mean. The last two columns "
      "are differences from " +
      first + ", and from holding the last fitted frame; all intervals to " + first +
      " hold together with 95 %. Intervals cover the simulation's seeds, not other surfaces or searches: an interval "
      "without width means that seeds change nothing, not that the figure is certain.");
  add_numbers(page, all);
  add_pictures(page, all);
  std::vector<std::string> header{"model"};
  for (const RankingCase& c : r.cases) header.push_back(case_text(c));
  rows.clear();
  for (const RankedModel& m : r.models) {
    std::vector<std::string>& row = rows.emplace_back(std::vector<std::string>{m.name});
    for (const std::size_t i : m.fits) row.push_back(figure_text(all.fits[i].fit.held_out->after));
  }
  std::vector<std::string>& held = rows.emplace_back(std::vector<std::string>{"the last frame seen, held"});
  for (const RankingCase& c : r.cases) held.push_back(figure_text(c.last_frame));
  page.heading("Case by case, the best values with the fit's own seed");
  page.table(header, rows);
  rows.clear();
  for (const RankedModel& m : r.models) {
    for (const std::size_t i : m.fits)
      rows.push_back({all.fits[i].name, m.name, all.fits[i].fit.history, all.fits[i].fit.origin.key});
  }
  page.heading("Fits");
  page.table({"fit", "model", "history", "key"}, rows);
  page.heading("Methods");
  page.paragraph(
      "Student's intervals of means; of differences and of means over cases with the degrees of freedom of B. L. "
      "Welch, The generalization of \"Student's\" problem when several different population variances are involved, "
      "Biometrika 34 (1947) 28-35. Frames after a time as a test of models: R. J. Hyndman, G. Athanasopoulos, "
      "Forecasting: principles and practice, 3rd ed., 2021, section 5.8.");
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(all.task.command);
  page.link(kRankingReportFile, "The figures as JSON");
  page.link(kRankingTableFile, "The figures as a table");
  page.save(folder / kRankingPageFile);
}

std::string table_csv(const Ranked& all) {
  const std::string unit = all.ranking.unit.empty() ? "" : " (" + all.ranking.unit + ")";
  std::string text = "model,cases,numbers varied,seen frames" + unit + ",held-out frames" + unit +
                     ",low,high,farther than the first" + unit + ",low,high,last frame held" + unit + ",converged\n";
  for (const RankedModel& m : all.ranking.models) {
    const Estimate behind = m.behind.value_or(Estimate{});
    text += csv_cell(m.name) + "," + std::to_string(m.fits.size()) + "," + std::to_string(num_numbers(all.fits, m));
    for (const std::optional<double>& v :
         {std::optional(seen(all.fits, m)), std::optional(m.held_out.value), m.held_out.low, m.held_out.high,
          m.behind ? std::optional(behind.value) : std::nullopt, behind.low, behind.high, all.ranking.last_frame})
      text += "," + csv_cell(v);
    text += is_converged(all, m) ? ",yes\n" : ",no\n";
  }
  return text;
}

}  // namespace

std::vector<RankedFit> read_ranked_fits(const std::vector<fs::path>& fits, const std::vector<std::string>& names) {
  std::vector<RankedFit> out;
  for (std::size_t i = 0; i < fits.size(); ++i) out.push_back({names[i], read_fit_manifest(fits[i])});
  return out;
}

namespace {

/// Of nine significant digits.
void describe_number(DocumentVisitor& v, const Member& m, std::optional<double> value) {
  if (value) value = rounded(*value, 9) + 0.0;
  v.member(m, value);
}

void describe_fit(DocumentVisitor& v, RankedFit& f) {
  std::vector<double> seeds = other_seeds(f);
  v.member({"name"}, f.name);
  v.member({"key"}, f.fit.origin.key);
  v.member({"history"}, f.fit.history);
  v.member({"until"}, f.fit.held_out->until);
  describe_number(v, {"seen", "", at_least(0)}, f.fit.objective_after);
  describe_number(v, or_null("held_out", "With the fit's own seed."), f.fit.held_out->after);
  v.member({.name = "other_seeds", .range = at_least(0), .min_size = 1}, seeds);
  v.list({.name = "varied",
          .help = "What the fit varied; another model may vary other numbers.",
          .presence = Presence::Optional},
         f.fit.numbers, [&](FittedNumber& n) {
           std::string name = n.name();
           v.member({"number", "JSON pointer into the scene, and the capture whose own it is."}, name);
           v.member({"unit", "Empty where it has none."}, n.unit);
           v.member({"best"}, n.best);
           v.member({"verdict", "What the frames seen say of it."}, n.verdict);
         });
  v.member({"converged"}, f.fit.is_converged);
}

void describe_model(DocumentVisitor& v, RankedModel& m, std::span<const RankedFit> fits) {
  std::size_t numbers = num_numbers(fits, m);
  std::vector<RankedFit> its;
  for (const std::size_t i : m.fits) its.push_back(fits[i]);
  v.member({"model", "Name of the scene."}, m.name);
  v.member({"numbers", "Varied by the search.", at_least(1)}, numbers);
  describe_number(
      v,
      {"seen", "Objective of the frames that the search saw, with the best values; mean over the cases.", at_least(0)},
      seen(fits, m));
  v.member(
      {"held_out",
       "Objective of the frames that it did not see: mean over other seeds and cases, 95 % interval of that mean."},
      m.held_out);
  v.member(or_null("behind",
                   "How much farther than the first model; null for the first. All of them hold together in 95 %."),
           m.behind);
  v.member(or_null("beyond_last_frame", "How much farther than the last frame seen, held."), m.beyond_last);
  v.list({.name = "fits", .min_size = 1}, its, [&](RankedFit& f) { describe_fit(v, f); });
}

void describe_ranking(DocumentVisitor& v, Ranking ranking, std::span<const RankedFit> fits) {
  std::vector<std::string> verdict = ranking_verdict(ranking, fits);
  v.member({"unit", "Of the objective, where all of its figures have one; else empty."}, ranking.unit);
  v.list({.name = "models", .help = "The nearest first.", .min_size = 1}, ranking.models,
         [&](RankedModel& m) { describe_model(v, m, fits); });
  v.list({.name = "cases", .help = "Histories, and the times up to which searches saw them.", .min_size = 1},
         ranking.cases, [&](RankingCase& c) {
           v.member({"history"}, c.history);
           v.member({"key"}, c.history_key);
           v.member({"until"}, c.until);
           v.member({.name = "time_unit",
                     .help = "Of `until`; empty where a fit of an earlier version does not say.",
                     .presence = Presence::Optional},
                    c.time_unit);
           describe_number(v, or_null("last_frame", "Objective of the last frame seen, held."), c.last_frame);
         });
  describe_number(v, or_null("last_frame", "The same, mean over the cases."), ranking.last_frame);
  v.member({.name = "verdict", .min_size = 1}, verdict);
}

constexpr DocumentKind kRankingDocument{
    .format = "patinate.ranking",
    .title = "patinate ranking of fits",
    .about =
        "report.json of `patinate fit rank`: which of several models foretells a history best, by frames that no "
        "search saw."};

void describe_document(DocumentVisitor& v, const Ranking& ranking, std::span<const RankedFit> fits, std::string command,
                       std::string key) {
  describe_ranking(v, ranking, fits);
  v.member({"command", "What repeats the page, byte for byte."}, command);
  v.member({"key", "Content key of the fits, their names and the version."}, key);
}

}  // namespace

void describe(DocumentVisitor& v, Estimate& e) {
  describe_number(v, {"value"}, e.value);
  describe_number(v, or_null("low", "95 %."), e.low);
  describe_number(v, or_null("high"), e.high);
}

Json ranking_json(const Ranking& ranking, std::span<const RankedFit> fits) {
  return object_json([&](DocumentVisitor& v) { describe_ranking(v, ranking, fits); });
}

Json ranking_schema() {
  std::vector<RankedFit> fits(1);
  fits.front().fit.held_out.emplace();
  fits.front().fit.numbers.emplace_back();
  const Ranking ranking{.models = {{.fits = {0}}}};
  return document_schema(kRankingDocument, [&](DocumentVisitor& v) { describe_document(v, ranking, fits, "", ""); });
}

JobPlan plan_ranking(RankingTask task, const fs::path& output) {
  const auto all = std::make_shared<Ranked>(Ranked{.task = std::move(task), .fits = {}, .ranking = {}});
  JobInputs inputs("rank", kRankingVersion);
  all->fits = read_ranked_fits(all->task.fits, all->task.names);
  for (std::size_t i = 0; i < all->fits.size(); ++i) {
    inputs.add_content("fit", all->task.names[i], all->fits[i].fit.origin.key);
    inputs.add_value("fit " + std::to_string(i + 1), all->task.names[i]);
    // A fit of an earlier version has none.
    inputs.add_value("pictures " + std::to_string(i + 1),
                     fs::exists(folder_of(all->task, i) / kHeldOutFolder) ? "yes" : "no");
  }
  all->ranking = rank_fits(all->fits);
  JobPlan plan = inputs.plan(output, kRankingReportFile);
  plan.join = [all, key = plan.key](const fs::path& folder, const RunControl&) {
    write_page(folder, *all);
    write_atomically(folder / kRankingTableFile, table_csv(*all));
    save_json(folder / kRankingReportFile, document_json(kRankingDocument, [&](DocumentVisitor& v) {
                describe_document(v, all->ranking, all->fits, all->task.command, key);
              }));
  };
  return plan;
}

}  // namespace patinate::analysis
