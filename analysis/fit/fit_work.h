/// \file
/// What the items of a fit share: the search as its finished evaluations leave it. It is worked out from the files of a
/// folder, so that a killed fit resumes from them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fit/determined.h"
#include "analysis/fit/fit_job.h"
#include "analysis/fit/fit_objective.h"
#include "analysis/fit/fit_record.h"
#include "analysis/fit/fit_search.h"
#include "analysis/fit/multi_start.h"
#include "patinate/core/run_control.h"

namespace patinate::analysis {

/// The file of an evaluation in a fit's folder.
[[nodiscard]] std::filesystem::path fit_record_file(const std::string& name);

/// Any number of items may ask at a time; finished evaluations are read once. @param folder  Of the fit, in every call.
class FitWork {
 public:
  explicit FitWork(FitTask given);

  FitTask task;
  FitModel model;
  std::vector<std::size_t> aged, appearance;  ///< Indices of the parameters that need aging, and that need none.
  FitBudget budget;
  std::vector<double> start;

  /// The model with its objective, which is opened on the first call.
  [[nodiscard]] const FitModel& ready(const RunControl& control);

  [[nodiscard]] int num_generations() const { return aged.empty() ? 0 : (budget.evaluations - 1) / budget.population; }
  [[nodiscard]] std::string candidate_name(int generation, int k) const;

  /// Record of a finished item. @throws IoError
  [[nodiscard]] FitEvaluation record(const std::filesystem::path& folder, const std::string& name);

  /// The search as it stands before a generation, from the records of those before.
  struct Standing {
    MultiStart search;
    /// By origin (MultiStart): the least objective, and values of all parameters with it.
    struct Best {
      double value = std::numeric_limits<double>::infinity();
      std::vector<double> values;
    };
    std::map<std::size_t, Best> best;

    /// Initial values of the parameters that need no aging: as the best of its start; in the design: as
    /// the start.
    [[nodiscard]] const std::vector<double>& values_for(int k) const;
  };
  [[nodiscard]] Standing standing(const std::filesystem::path& folder, int generation);

  /// Everything that the search tried, in its order.
  [[nodiscard]] std::vector<FitEvaluation> searched(const std::filesystem::path& folder);
  /// @throws InvalidInput if nothing that was tried could be compared.
  [[nodiscard]] FitPoint best(const std::filesystem::path& folder);

  /// Objectives by chance at the best: of the items seed-1, seed-2, ...
  [[nodiscard]] std::vector<double> chances(const std::filesystem::path& folder);

  /// Values of all parameters at places along one, the others as at the best.
  [[nodiscard]] std::vector<std::vector<double>> scan_values(const std::vector<double>& best, std::size_t i) const;

  [[nodiscard]] BoxPoint box_point(const FitPoint& p) const;
  /// Where the search has been, and how it slopes there.
  struct Ground {
    std::vector<BoxPoint> tried;
    std::optional<Valley> valley;
    std::string no_valley;
  };
  [[nodiscard]] const Ground& ground(const std::filesystem::path& folder);

 private:
  /// Its least objective; remembers it as one of an origin.
  double keep(const FitEvaluation& e, std::size_t origin);

  std::mutex mutex_, search_mutex_;
  std::vector<FitObjective> objectives_, held_out_;  ///< One a capture, once they are open.
  std::map<std::string, FitEvaluation> records_;
  std::optional<Standing> search_;
  std::optional<Ground> ground_;
};

}  // namespace patinate::analysis
