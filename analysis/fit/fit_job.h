/// \file
/// Finding a model's parameters as a job: every evaluation is an item, so that a killed search resumes, and a larger
/// budget begins where a smaller ended.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/fit/determined.h"
#include "analysis/fit/fit_objective.h"
#include "analysis/fit/fit_parameter.h"
#include "analysis/report/report_page.h"
#include "libcommon/job/job_inputs.h"

namespace patinate::analysis {

inline constexpr const char* kFitReportFile = "report.json";
inline constexpr const char* kFitPageFile = "report.html";
inline constexpr const char* kFitDrawingsFolder = "curves";
inline constexpr const char* kFitTableFile = "evaluations.csv";
/// With frames held out: pictures of the last compared of them, captured and simulated with the best values.
inline constexpr const char* kHeldOutFolder = "held_out";
inline constexpr const char* kHeldOutCaptured = "captured";    ///< Stem of a PNG's name (file_of_capture()).
inline constexpr const char* kHeldOutSimulated = "simulated";  ///< Stem of the simulated one's name.

struct FitOptions {
  int evaluations = 0;  ///< Budget of the search; 0 = 100 for each parameter that is searched, at least 200. When all
                        ///< parameters are of appearance, it counts appearances.
  int appearance_evaluations = 30;  ///< For each aging at most, where some parameters need none; [1, 100000].
  int repeats = 1;                  ///< Seeds over which an objective is averaged; [1, 100].
  int population = 0;               ///< Candidates a generation; 0 = by the number of parameters.
  double step = 0.3;                ///< First standard deviation, share of a range; (0, 1].
  double tolerance = 1e-3;          ///< At an end when the candidates' spread is below this share of every range.
  int starts = 4;                   ///< Valleys that the search follows at most; 1: from the given values alone.
  int scan = 8;                     ///< Evaluations a parameter for what the data determine; 0 = none.
  int seeds = 8;  ///< Other seeds of the best that take the capture's place: what chance makes; 0 = none.
};
void describe(OptionVisitor& v, FitOptions& o);
/// Evaluations that the search may use, and the least that make sense (the start and two generations).
/// @param num_aged, num_appearance  Parameters that need aging, and that need none.
struct FitBudget {
  int evaluations = 0;
  int least = 0;
  int population = 0;
};
/// Problem of a budget below the least.
[[nodiscard]] std::string budget_problem(const FitBudget& budget);
[[nodiscard]] FitBudget fit_budget(const FitOptions& options, std::size_t num_aged, std::size_t num_appearance);

/// A captured history, and the model of it.
struct FitCapture {
  std::filesystem::path history;  ///< Or a transfer.
  std::string name = {};          ///< For the report, where there are several; they differ.
  SurfaceOutline outline = {};
  /// Takes the values of those parameters that all captures share or that are its own, in their order. Chance is to be
  /// another one in every capture.
  AgeWith age = {};
  /// The model's own file with these values, those that `age` takes. @param file  Name without extension.
  std::function<void(const std::filesystem::path& folder, const std::string& file, const std::vector<double>& values)>
      write_model = {};
};

struct FitTask {
  std::string model_name;                ///< For the report.
  std::vector<FitParameter> parameters;  ///< At least one; names differ, or captures.
  std::vector<FitCapture> captures;      ///< At least one. The objective is the mean of theirs.
  std::vector<FitTerm> terms;
  ObjectiveOptions objective;
  FitOptions options;
  std::uint64_t seed = 0;  ///< Seed of the search.
  std::function<void(JobInputs& inputs)>
      add_inputs;       ///< All that the models depend on beside their parameters' values.
  std::string command;  ///< Command that repeats it, for the report; no part of the key.
};

/// Name of a capture's files, without extension: "after", or "after_2" where there are several. @param capture
/// Counted from 0.
[[nodiscard]] std::string file_of_capture(std::size_t num_captures, const std::string& stem, std::size_t capture);
/// The PNG of a capture's last held-out frame. @param stem  kHeldOutCaptured or kHeldOutSimulated.
[[nodiscard]] std::filesystem::path held_out_picture(const std::filesystem::path& fit, std::size_t num_captures,
                                                     const char* stem, std::size_t capture);
/// A parameter in tables: "/rules/0/rate", or "/rules/0/rate (shaded)" where it is that capture's own.
[[nodiscard]] std::string column_of(const FitTask& task, std::size_t parameter);

/// report.html, report.json, evaluations.csv, evaluations/*.json, the model's file, and `before` and `after`: histories
/// with the starting and the best values; with frames held out also pictures in `held_out`. Of several captures each
/// has its model's file, its histories and its pictures (file_of_capture()).
/// @throws InvalidInput if a history cannot be compared with its outline (FitObjective), a start lies outside its
/// range, frames are held out of histories with different units of time, or the budget is below the least; IoError.
[[nodiscard]] JobPlan plan_fit(FitTask task, const std::filesystem::path& output);

/// The frames that no search saw, of one capture.
struct HeldOutCapture {
  std::string name = {};
  std::optional<double> before = {}, after = {}, last_frame = {};  ///< Objectives as in HeldOut.
  std::string shown = {};                                          ///< "480 min", the time of the pictures.
};

/// How well the frames are foretold that no search saw: objectives of those frames alone.
struct HeldOut {
  double until = 0.0;  ///< In the history's unit: frames after it.
  std::size_t num_times = 0;
  std::optional<double> before = {}, after = {};        ///< With the starting and with the best values.
  std::vector<std::optional<double>> other_seeds = {};  ///< The best values, another seed each.
  std::optional<double> last_frame = {};      ///< The history's last frame that was seen, held: no model at all.
  std::vector<HeldOutCapture> captures = {};  ///< Each by itself; none where there are no pictures of one.
  std::string time_unit = {};  ///< Of the histories: all have one; "" where a fit of an earlier version does not say.
};

/// A figure of the objective, and what became of it.
struct FittedTerm {
  std::string figure = {};
  double weight = 1.0;
  std::string unit = {};
  std::optional<double> before = {}, after = {};
};

/// A parameter, and what was found of it.
struct FittedNumber {
  std::string pointer = {}, words = {}, unit = {}, capture = {};  ///< As in FitParameter.
  double low = 0.0, high = 1.0;
  FitScale scale = FitScale::Linear;
  bool needs_aging = true;
  double initial = 0.0, best = 0.0;
  std::array<double, 2> interval = {};  ///< Values that the figures cannot tell from the best.
  ParameterVerdict found = {};
  std::string verdict = {};

  /// As column_of() calls it.
  [[nodiscard]] std::string name() const { return pointer + (capture.empty() ? "" : " (" + capture + ")"); }
};

/// One of several captures.
struct FittedCapture {
  std::string name = {}, history = {}, key = {};
  std::optional<double> before = {}, after = {};
};

/// A figure of a comparison, and what became of it.
struct FigureChange {
  Figure before;
  std::optional<double> after;
  std::string capture = {};  ///< Whose, where there are several.
};

/// report.json.
struct FitManifest {
  std::string history, history_key, model;  ///< Of several captures: "open and shaded", all keys.
  std::optional<double> objective_before;
  double objective_after = 0.0;
  std::vector<FittedTerm> terms;
  std::vector<std::optional<double>> other_seeds;  ///< The best with other seeds.
  std::vector<double> chances;                     ///< As FitOutcome has it, and so on.
  double threshold = 0.0;
  std::optional<HeldOut> held_out;
  std::vector<FittedNumber> numbers;
  std::vector<std::vector<double>> correlation;
  std::string no_correlation;
  int num_planned = 0, num_agings = 0, num_points = 0;
  bool is_converged = false;
  std::optional<double> lately_gained;
  std::vector<FigureChange> figures;
  ReportOrigin origin;
  std::vector<FittedCapture> captures;  ///< None where there is one.

  [[nodiscard]] std::size_t num_captures() const { return std::max<std::size_t>(1, captures.size()); }
};
/// @throws IoError
[[nodiscard]] FitManifest read_fit_manifest(const std::filesystem::path& path);

}  // namespace patinate::analysis
