/// \file
/// Which of several fitted models foretells a history best: by frames that none of their searches saw.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/fit/fit_job.h"

namespace patinate::analysis {

/// A mean and where it lies; no interval where fewer than two values say how much they scatter.
struct Estimate {
  double value = 0.0;
  std::optional<double> low = {}, high = {};
  [[nodiscard]] bool has_interval() const { return low.has_value(); }
};

/// A finished fit with frames held out, as it was named.
struct RankedFit {
  std::string name = {};
  FitManifest fit = {};
};

/// Objectives of the frames held out by the best values with other seeds, where there are any.
[[nodiscard]] std::vector<double> other_seeds(const RankedFit& fit);

/// A history and the time up to which searches saw it.
struct RankingCase {
  std::string history = {}, history_key = {};
  double until = 0.0;                     ///< In the history's unit.
  std::string time_unit = {};             ///< That unit; "" where a fit of an earlier version does not say.
  std::optional<double> last_frame = {};  ///< Objective of the last frame seen, held: what any model has to beat.
  bool operator<(const RankingCase& other) const;
};

/// "copper until 300 min".
[[nodiscard]] std::string case_text(const RankingCase& ranking_case);

struct RankedModel {
  std::string name = {};                     ///< Name of its scene.
  std::vector<std::size_t> fits = {};        ///< One a case, in their order; indices of what was ranked.
  Estimate held_out = {};                    ///< Mean over the cases, each a mean over seeds of the simulation; 95 %.
  std::optional<Estimate> behind = {};       ///< How much farther than the first; nothing of the first itself.
  std::optional<Estimate> beyond_last = {};  ///< How much farther than the last frame seen, held.
};

struct Ranking {
  std::vector<RankingCase> cases = {};
  std::vector<RankedModel> models = {};   ///< The nearest first.
  std::optional<double> last_frame = {};  ///< Mean over the cases.
  std::string unit = {};                  ///< Unit of the objective, where its figures have one.
};

/// Means over seeds as estimates of what the model gives: intervals are Student's, for means over cases and for
/// differences with the degrees of freedom of Welch and Satterthwaite. Those of `behind` hold together in 95 %
/// (Bonferroni). They hold what chance makes in the model, not what it made in the capture, which is one.
/// @param fits  Two or more. @throws InvalidInput naming the fit: that holds no frames out, has another objective,
/// other options of comparing or another case than the first model, or is the second of one model and case.
[[nodiscard]] Ranking rank_fits(std::span<const RankedFit> fits);

/// Conclusions, a sentence each.
[[nodiscard]] std::vector<std::string> ranking_verdict(const Ranking& ranking, std::span<const RankedFit> fits);

}  // namespace patinate::analysis
