#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/fit/fit_job.h"
#include "analysis/fit/fit_ranking_job.h"
#include "analysis/fit/fit_search.h"
#include "analysis/fit/multi_start.h"
#include "app/fit/fit_captures.h"
#include "app/request/repeating_command.h"
#include "patinate/core/error.h"
#include "patinate/history/memory_history.h"
#include "python/analysis/py_analysis.h"
#include "python/bindings.h"
#include "python/history/given_history.h"
#include "python/simulation/scene_argument.h"
#include "python/support/arrays.h"
#include "python/support/json.h"
#include "python/support/keywords.h"
#include "python/support/signature.h"

namespace patinate::python {

namespace py = pybind11;

namespace {

struct FitKeywords {
  int evaluations = 60;
  analysis::EvolutionOptions search = {};
  int starts = analysis::MultiStartOptions{}.starts;
  std::int64_t seed = kDefaultSeed;
};
void describe(OptionVisitor& v, FitKeywords& o) {
  v.visit({"evaluations", "Budget: so often is the objective asked for, whole generations", "", between(1, 1e6)},
          o.evaluations);
  v.visit({"population", "Candidates a generation; 0 = by the number of parameters", "", between(0, 1000)},
          o.search.population);
  v.visit({"step", "Standard deviation at the start, as a share of a range", "",
           Range{.low = 0, .high = 1, .is_low_open = true}},
          o.search.step);
  v.visit({"tolerance", "Converged when the candidates' spread is below this share of every range", "", above(0)},
          o.search.tolerance);
  v.visit({"starts", "Valleys that the search follows at most; 1 = from the start alone", "", between(1, 100)},
          o.starts);
  v.visit({"seed", "Of all random numbers", "", at_least(0)}, o.seed);
}

/// {"name": (low, high) or (low, high, "log")}.
std::vector<analysis::FitRange> ranges_from(const char* function, const py::object& given) {
  if (!py::isinstance<py::dict>(given))
    wrong_type(function, "vary", given, "a dict of (low, high) or (low, high, 'log')");
  std::vector<analysis::FitRange> out;
  for (const auto& [name, range] : py::cast<py::dict>(given)) {
    const auto key = py::cast<std::string>(name);
    if (!py::isinstance<py::sequence>(range) || py::len(range) < 2 || py::len(range) > 3)
      wrong_type(function, "vary[" + key + "]", range, "(low, high) or (low, high, 'log')");
    const auto parts = py::reinterpret_borrow<py::sequence>(range);
    analysis::FitRange r{.name = key, .low = py::cast<double>(parts[0]), .high = py::cast<double>(parts[1])};
    const std::string scale = parts.size() == 3 ? py::cast<std::string>(parts[2]) : std::string("linear");
    if (scale != "linear" && scale != "log")
      throw InvalidInput("vary[" + key + "]: found `" + scale + "`; expected linear or log");
    r.scale = scale == "log" ? analysis::FitScale::Log : analysis::FitScale::Linear;
    if (!(r.low < r.high) || !std::isfinite(r.low) || !std::isfinite(r.high) || (scale == "log" && !(r.low > 0.0)))
      throw InvalidInput("vary[" + key + "]: expected low < high" + std::string(scale == "log" ? ", above 0" : ""));
    out.push_back(std::move(r));
  }
  if (out.empty()) throw InvalidInput("vary: nothing may vary; give at least one range");
  return out;
}

/// By name; of what is each history's own, a list.
py::dict values_of(const std::vector<analysis::FitParameter>& parameters, const std::vector<double>& values) {
  py::dict out;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const char* const name = parameters[i].range.name.c_str();
    if (!parameters[i].capture) {
      out[name] = values[i];
    } else {
      if (!out.contains(name)) out[name] = py::list();
      py::cast<py::list>(out[name]).append(values[i]);
    }
  }
  return out;
}

/// Minimizes a function of the parameters' values, which may throw what Python raised.
py::dict minimized(const std::vector<analysis::FitParameter>& parameters, const FitKeywords& keywords,
                   const RunArguments& run,
                   const std::function<double(const std::vector<double>&, const RunControl&)>& function) {
  std::vector<double> start;
  for (const analysis::FitParameter& p : parameters) start.push_back(unit_at(p, p.start));
  analysis::EvolutionOptions options = keywords.search;
  options.seed = static_cast<std::uint64_t>(keywords.seed);
  std::vector<std::pair<std::vector<double>, double>> tried;
  analysis::Minimum best;
  run_borrowing(run, [&](const RunControl& control) {
    const RunControl inner = control.silent();
    const auto objective = [&](const std::vector<double>& unit) {
      control.throw_if_stopped();
      std::vector<double> values;
      for (std::size_t i = 0; i < unit.size(); ++i) values.push_back(value_at(parameters[i], unit[i]));
      const double value = function(values, inner);
      if (std::isnan(value)) throw InvalidInput("objective: is NaN; return infinity where it is undefined");
      tried.emplace_back(std::move(values), value);
      control.report(std::min(1.0, static_cast<double>(tried.size()) / keywords.evaluations));
      return value;
    };
    best = analysis::minimize(objective, start, keywords.evaluations, {.search = options, .starts = keywords.starts});
    control.report(1.0);  // Whole generations, or a convergence, leave some of the budget.
  });
  std::vector<double> values;
  for (std::size_t i = 0; i < best.at.size(); ++i) values.push_back(value_at(parameters[i], best.at[i]));
  py::dict out;
  out["values"] = values_of(parameters, values);
  out["objective"] = best.value;
  out["is_converged"] = best.is_converged;
  py::list history;
  for (const auto& [at, value] : tried) history.append(py::make_tuple(values_of(parameters, at), value));
  out["evaluations"] = history;
  return out;
}

/// Value that a Python function gives an object, from a thread that does not hold the interpreter's lock.
template <class MakeArgument>
double asked(const py::object& function, const MakeArgument& make) {
  const py::gil_scoped_acquire locked;
  return py::cast<double>(function(make()));
}

PyHistory history_of(const analysis::AgedSurface& surface) {
  MemoryHistoryImages images{.name = surface.name,
                             .origin = "simulated",
                             .texel_size_mm = surface.texel_size_mm,
                             .time_unit = surface.time_unit,
                             .frames = {},
                             .mask = surface.mask};
  for (std::size_t i = 0; i < surface.times.size(); ++i)
    images.frames.push_back({.time = surface.times[i], .color = surface.colors[i]});
  for (const analysis::SurfaceControl& c : surface.controls)
    images.controls.push_back({.facts = c.parameter, .values = c.values});
  return {std::make_shared<const MemoryHistory>(std::move(images))};
}

std::vector<analysis::FitTerm> terms_from(const py::object& figures) {
  std::vector<analysis::FitTerm> terms;
  if (!figures.is_none()) {
    for (const auto& [name, weight] : py::cast<py::dict>(figures)) {
      terms.push_back(analysis::parse_fit_term(py::cast<std::string>(name)));
      terms.back().weight = py::cast<double>(weight);
      if (!(terms.back().weight > 0.0)) throw InvalidInput("figures: weights are > 0");
    }
  }
  if (terms.empty()) terms.emplace_back();
  return terms;
}

/// Histories that a fit comes close to: one or several; none of a function.
std::vector<std::shared_ptr<const History>> histories_from(const py::object& objective) {
  const auto is_one = [](const py::handle& given) {
    return py::isinstance<PyHistory>(given) || py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__");
  };
  if (is_one(objective)) return {history_from("fit", "objective", objective).value};
  if (PyCallable_Check(objective.ptr()) != 0) return {};
  std::vector<std::shared_ptr<const History>> histories;
  if (py::isinstance<py::sequence>(objective)) {
    for (const py::handle one : py::reinterpret_borrow<py::sequence>(objective))
      histories.push_back(history_from("fit", "objective", py::reinterpret_borrow<py::object>(one)).value);
  }
  if (histories.empty())
    wrong_type("fit", "objective", objective, "a History or its path, several of them, or a function");
  return histories;
}

/// Shared ranges, and each history's own.
std::vector<analysis::FitRange> all_ranges(const py::object& vary, const py::object& own, std::size_t num_histories) {
  if (own.is_none()) return ranges_from("fit", vary);
  if (num_histories < 2) throw InvalidInput("own: is each history's own; give several histories");
  std::vector<analysis::FitRange> ranges;
  if (py::len(vary) > 0) ranges = ranges_from("fit", vary);
  for (analysis::FitRange& range : ranges_from("fit", own)) {
    range.is_own = true;
    ranges.push_back(std::move(range));
  }
  return ranges;
}

/// A history with the scene that is to come close to it.
struct FittedHistory {
  analysis::AgeWith age;
  std::optional<analysis::FitObjective> distance;  ///< None of a function.
};

py::dict fit_scene(const py::object& scene_given, const py::object& objective, const py::object& vary,
                   const py::kwargs& kwargs) {
  Keywords words("fit", kwargs);
  FitKeywords keywords;
  analysis::ObjectiveOptions compared;
  words.read(keywords);
  words.read(compared);
  const py::object figures = words.object("figures"), own = words.object("own");
  const SceneArgument given = scene_from("fit", scene_given, words);
  const RunArguments run = words.run();
  words.finish();
  const std::vector<std::shared_ptr<const History>> histories = histories_from(objective);
  const std::vector<analysis::FitRange> ranges = all_ranges(vary, own, histories.size());
  const std::vector<analysis::FitTerm> terms = terms_from(figures);
  const RunArguments silent{.num_threads = run.num_threads};
  const auto room = std::make_shared<std::optional<TemporaryFolder>>();
  const std::filesystem::path path =
      result_of(silent, [=](const RunControl& control) { return given.written(*room, control); });
  std::vector<app::FitScene> scenes;
  std::vector<std::string> names;
  std::vector<FittedHistory> fitted;
  for (std::size_t c = 0; c < std::max<std::size_t>(1, histories.size()); ++c) {
    const std::shared_ptr<const History> history = histories.empty() ? nullptr : histories[c];
    std::vector<std::string> controls;
    if (history) {
      for (const ControlFacts& f : history->facts().controls) controls.push_back(f.name);
    }
    const app::FitScene scene = result_of(
        silent, [=](const RunControl& control) { return app::scene_of_capture(c, path, ranges, controls, control); });
    FittedHistory& one = fitted.emplace_back(FittedHistory{.age = scene.age(), .distance = {}});
    if (history) {
      one.distance.emplace(result_of(silent, [=](const RunControl& control) {
        return analysis::FitObjective(analysis::TextureSeries(history), scene.outline(), terms, compared,
                                      analysis::FitFrames::Seen, control);
      }));
    }
    scenes.push_back(scene);
    names.push_back(std::to_string(c));
  }
  analysis::FitModel model;
  model.parameters = app::joint_parameters(scenes, ranges, names);
  return minimized(model.parameters, keywords, run, [&](const std::vector<double>& values, const RunControl& control) {
    double sum = 0.0;
    for (std::size_t c = 0; c < fitted.size(); ++c) {
      const std::vector<double> its = model.values_of(c, values);
      const analysis::AgedSurface surface = fitted[c].age(its, 0, control)(its, control);
      if (!fitted[c].distance) return asked(objective, [&] { return py::cast(history_of(surface)); });
      sum += (*fitted[c].distance)(surface, control).objective.value_or(std::numeric_limits<double>::infinity());
    }
    return sum / static_cast<double>(fitted.size());
  });
}

void bind_rank(py::module_& module) {
  define(
      module,
      FunctionText("rank",
                   "Which of several fitted scenes foretells a history best, by frames that none of their "
                   "searches saw.")
          .takes("fits", "Sequence[str | os.PathLike[str]]",
                 "Folders of `patinate fit --until`, two or more: of every scene one a history and time")
          .runs()
          .returns("Report",
                   "unit of the objective; models, the nearest first: model, numbers (varied), seen, held_out (value, "
                   "low, high: 95 % over seeds), behind the first, beyond_last_frame, fits; cases; last_frame, held; "
                   "verdict, sentences")
          .raises("IoError if a file cannot be read; InvalidInput naming a fit that cannot be ranked"),
      [](const py::sequence& given, const py::kwargs& kwargs) {
        Keywords keywords("rank", kwargs);
        const RunArguments run = keywords.run();
        keywords.finish();
        std::vector<std::filesystem::path> fits;
        std::vector<std::string> names;
        for (const py::handle fit : given) {
          fits.emplace_back(path_from(py::reinterpret_borrow<py::object>(fit)));
          names.push_back(app::input_word(fits.back()));
        }
        return object_of(result_of(run, [=](const RunControl&) {
          const std::vector<analysis::RankedFit> read = analysis::read_ranked_fits(fits, names);
          return analysis::ranking_json(analysis::rank_fits(read), read);
        }));
      });
}

}  // namespace

void bind_fit(py::module_& module) {
  bind_rank(module);
  const char* const result =
      "values (by name), objective (the least), is_converged, evaluations (what was tried: values and objective, in "
      "order)";
  FunctionText text(
      "fit",
      "The numbers of a simulation that bring it closest to a history, or make a function of its history least.");
  text.takes("scene", kSceneType, "A scene file with the starting values, or what would stand in one")
      .takes("objective",
             "History | str | os.PathLike[str] | Sequence[History | str | os.PathLike[str]] | "
             "Callable[[History], float]",
             "What it should come close to, by `figures`; several at once, by the mean; or a function of the "
             "simulated "
             "history, the less the better")
      .takes("vary", "Mapping[str, tuple[float, float] | tuple[float, float, str]]",
             "JSON pointers of numbers of the scene, '/rules/0/rate': (low, high) or (low, high, 'log')");
  scene_text(text)
      .keyword("own", "Mapping[str, tuple[float, float] | tuple[float, float, str]] | None", "None",
               "The same, where each of several histories has a value of its own; found values are lists")
      .keyword("figures", "Mapping[str, float] | None", "None",
               "Weights of color_distribution, mean_color, covered, onset, saturation, color_by_control, "
               "rate_by_control, ciede2000, contrast, rusted; "
               "None: color_distribution")
      .options<FitKeywords>()
      .options<analysis::ObjectiveOptions>()
      .runs()
      .returns("Report", result)
      .raises("IoError for a scene that cannot be read with an end of a range; InvalidInput; what the function raises");
  define(module, text,
         [](const py::object& scene, const py::object& objective, const py::object& vary, const py::kwargs& kwargs) {
           return fit_scene(scene, objective, vary, kwargs);
         });
}

}  // namespace patinate::python
