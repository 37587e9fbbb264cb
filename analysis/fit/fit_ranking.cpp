#include "analysis/fit/fit_ranking.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "analysis/fit/held_out_report.h"
#include "libcommon/core/text.h"
#include "patinate/core/error.h"

namespace patinate::analysis {

namespace {

constexpr double kLevel = 0.05;
constexpr std::string_view kUntilOption = "until";  ///< ObjectiveOptions::until.

/// A mean of values that scatter, with the variance of it and the degrees of freedom behind that.
struct Mean {
  double value = 0.0;
  double variance = 0.0;
  double squares = 0.0;  ///< Sum of variance^2 / degrees of freedom, of all that went in.
  bool is_known = true;  ///< Whether the variance is.

  [[nodiscard]] Mean times(double factor) const {
    const double f2 = factor * factor;
    return {factor * value, f2 * variance, f2 * f2 * squares, is_known};
  }
  [[nodiscard]] Mean plus(const Mean& other) const {
    return {value + other.value, variance + other.variance, squares + other.squares, is_known && other.is_known};
  }
};

Mean mean_over_seeds(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  Mean mean{.value = std::accumulate(values.begin(), values.end(), 0.0) / n};
  mean.is_known = values.size() > 1;
  if (!mean.is_known) return mean;
  for (const double v : values) mean.variance += (v - mean.value) * (v - mean.value);
  mean.variance /= n * (n - 1.0);
  mean.squares = mean.variance * mean.variance / (n - 1.0);
  return mean;
}

/// @param level  Share of intervals that may miss.
Estimate estimate(const Mean& mean, double level) {
  Estimate e{.value = mean.value};
  if (!mean.is_known) return e;
  double half = 0.0;
  if (mean.squares > 0.0) {
    const double freedom = mean.variance * mean.variance / mean.squares;
    half = boost::math::quantile(boost::math::students_t(freedom), 1.0 - 0.5 * level) * std::sqrt(mean.variance);
  }
  e.low = mean.value - half;
  e.high = mean.value + half;
  return e;
}

const HeldOut& held_out(const RankedFit& fit) { return *fit.fit.held_out; }

bool is_same(const FittedTerm& a, const FittedTerm& b) { return a.figure == b.figure && a.weight == b.weight; }

/// An option that was in force, nothing where it was not.
std::optional<std::string> option_of(const RankedFit& fit, const std::string& name) {
  for (const auto& [given, value] : fit.fit.origin.options) {
    if (given == name) return value;
  }
  return std::nullopt;
}

void require_rankable(std::span<const RankedFit> fits) {
  if (fits.size() < 2) throw InvalidInput("two fits or more can be ranked");
  const RankedFit& first = fits.front();
  for (const RankedFit& f : fits) {
    if (!f.fit.held_out)
      throw InvalidInput(f.name + ": its search saw all frames; `fit --until TIME` holds those after it out");
    if (!held_out(f).after || other_seeds(f).empty())
      throw InvalidInput(f.name + ": has no objective of its held-out frames" +
                         (held_out(f).after ? " with other seeds; `fit --seeds 8` tries eight" : ""));
    if (!std::equal(f.fit.terms.begin(), f.fit.terms.end(), first.fit.terms.begin(), first.fit.terms.end(), is_same))
      throw InvalidInput(f.name + ": has another objective than " + first.name + "; such figures cannot be ranked");
    for (const auto& [name, standard] : option_values(ObjectiveOptions{})) {
      const std::optional<std::string> value = option_of(f, name), other = option_of(first, name);
      if (name != kUntilOption && value && other && *value != *other)
        throw InvalidInput(f.name + ": was compared with " + dashed(name) + " " + *value + ", " + first.name +
                           " with " + dashed(name) + " " + *other);
    }
  }
}

RankingCase case_of(const RankedFit& f) {
  return {f.fit.history, f.fit.history_key, held_out(f).until, held_out(f).time_unit, held_out(f).last_frame};
}

/// Fits by model, in the order of their first mention, and by case.
std::vector<RankedModel> grouped(std::span<const RankedFit> fits, const std::vector<RankingCase>& cases) {
  std::map<std::string, std::map<RankingCase, std::size_t>> by_model;
  std::vector<std::string> order;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const std::string& model = fits[i].fit.model;
    if (!by_model.contains(model)) order.push_back(model);
    const auto [at, is_new] = by_model[model].emplace(case_of(fits[i]), i);
    if (!is_new)
      throw InvalidInput(fits[i].name + " and " + fits[at->second].name + " are both of " + model + " and " +
                         case_text(at->first) + "; scenes to be told apart need files of different names");
  }
  std::vector<RankedModel> models;
  for (const std::string& name : order) {
    RankedModel& model = models.emplace_back();
    model.name = name;
    for (const RankingCase& c : cases) {
      const auto found = by_model[name].find(c);
      if (found == by_model[name].end())
        throw InvalidInput(name + ": has no fit to " + case_text(c) +
                           ", which others have; means over different cases "
                           "cannot be ranked");
      model.fits.push_back(found->second);
      const RankedFit &fit = fits[found->second], &first = fits[models.front().fits[model.fits.size() - 1]];
      if (held_out(fit).num_times != held_out(first).num_times)
        throw InvalidInput(fit.name + ": is judged at " + std::to_string(held_out(fit).num_times) + " times, " +
                           first.name + " at " + std::to_string(held_out(first).num_times) +
                           "; scenes that are ranked cover the same times");
    }
  }
  return models;
}

std::string unit_of(const FitManifest& fit) {
  std::set<std::string_view> units;
  for (const FittedTerm& term : fit.terms) {
    const auto at = std::find(kFitFigureNames.begin(), kFitFigureNames.end(), term.figure);
    units.insert(at == kFitFigureNames.end() ? "" : kFitFigureUnits[at - kFitFigureNames.begin()]);
  }
  return units.size() == 1 ? std::string(*units.begin()) : "";
}

std::string interval_text(const Estimate& e) {
  return e.has_interval() ? " (" + figure_text(*e.low) + " to " + figure_text(*e.high) + ")" : "";
}

}  // namespace

std::vector<double> other_seeds(const RankedFit& fit) {
  std::vector<double> defined;
  for (const std::optional<double>& v : held_out(fit).other_seeds) {
    if (v) defined.push_back(*v);
  }
  return defined;
}

std::string case_text(const RankingCase& c) { return c.history + " until " + until_text(c.until, c.time_unit); }

bool RankingCase::operator<(const RankingCase& other) const {
  return std::tie(history, history_key, until) < std::tie(other.history, other.history_key, other.until);
}

Ranking rank_fits(std::span<const RankedFit> fits) {
  require_rankable(fits);
  Ranking ranking;
  std::set<RankingCase> cases;
  for (const RankedFit& f : fits) cases.insert(case_of(f));
  ranking.cases.assign(cases.begin(), cases.end());
  ranking.models = grouped(fits, ranking.cases);
  ranking.unit = unit_of(fits.front().fit);
  const double share = 1.0 / static_cast<double>(ranking.cases.size());
  const bool is_last_known = std::all_of(cases.begin(), cases.end(), [](const auto& c) { return c.last_frame; });
  if (is_last_known) {
    ranking.last_frame = 0.0;
    for (const RankingCase& c : cases) *ranking.last_frame += share * *c.last_frame;
  }
  std::map<std::string, Mean> means;
  for (RankedModel& model : ranking.models) {
    Mean mean;
    for (const std::size_t i : model.fits) mean = mean.plus(mean_over_seeds(other_seeds(fits[i])).times(share));
    means[model.name] = mean;
    model.held_out = estimate(mean, kLevel);
    if (is_last_known) model.beyond_last = estimate(mean.plus({.value = -*ranking.last_frame}), kLevel);
  }
  std::stable_sort(ranking.models.begin(), ranking.models.end(),
                   [](const auto& a, const auto& b) { return a.held_out.value < b.held_out.value; });
  const double level = kLevel / std::max(1.0, static_cast<double>(ranking.models.size() - 1));
  for (auto model = ranking.models.begin() + 1; model < ranking.models.end(); ++model) {
    const Mean& first = means[ranking.models.front().name];
    model->behind = estimate(means[model->name].plus(first.times(-1.0)), level);
  }
  return ranking;
}

std::vector<std::string> ranking_verdict(const Ranking& ranking, std::span<const RankedFit> fits) {
  std::vector<std::string> text;
  const RankedModel& best = ranking.models.front();
  const std::string unit = ranking.unit.empty() ? "" : " " + ranking.unit;
  if (ranking.last_frame) {
    const Estimate& beyond = *best.beyond_last;
    const std::string last = "holding the last frame seen (" + figure_text(*ranking.last_frame) + unit + ")";
    const bool is_nearer = beyond.has_interval() && *beyond.high < 0.0;
    const bool is_farther = beyond.has_interval() && *beyond.low > 0.0;
    text.push_back(is_nearer    ? best.name + " is nearer than " + last
                   : is_farther ? "no model is as near as " + last
                                : best.name + " cannot be told from " + last);
  }
  text.push_back("of the models " + best.name + " is the nearest: " + figure_text(best.held_out.value) + unit +
                 interval_text(best.held_out));
  for (const RankedModel& m : ranking.models) {
    if (!m.behind) continue;
    const Estimate& by = *m.behind;
    const bool is_told = by.has_interval() && *by.low > 0.0;
    text.push_back(m.name + " is farther by " + figure_text(by.value) + interval_text(by) +
                   (is_told             ? ""
                    : by.has_interval() ? ": the two cannot be distinguished"
                                        : ": one seed cannot measure chance; use `fit --seeds 8`"));
  }
  std::string unfinished;
  for (const RankedFit& f : fits) {
    if (!f.fit.is_converged) unfinished += (unfinished.empty() ? "" : ", ") + f.name;
  }
  if (!unfinished.empty())
    text.push_back("the order is provisional: searches had not converged, which more --evaluations may bring nearer (" +
                   unfinished + ")");
  return text;
}

}  // namespace patinate::analysis
