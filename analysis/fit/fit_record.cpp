#include "analysis/fit/fit_record.h"

#include <nlohmann/json.hpp>

#include "libcommon/core/csv.h"
#include "libcommon/core/text.h"

namespace patinate::analysis {

namespace {

constexpr std::size_t kMaxPoints = 1'000'000, kMaxCaptures = 1000;

std::optional<double> read_number_or_null(const JsonReader& json) {
  return json.is_null() ? std::nullopt : std::optional(json.number());
}

}  // namespace

std::optional<std::size_t> FitEvaluation::best() const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].result.objective && (!best || *points[i].result.objective < *points[*best].result.objective))
      best = i;
  }
  return best;
}

Json evaluation_json(const FitEvaluation& evaluation) {
  Json points = Json::array();
  for (const FitPoint& p : evaluation.points) {
    Json figures = Json::array();
    for (const std::optional<double>& f : p.result.figures) figures.push_back(optional_json(f));
    Json point{{"values", p.values}, {"objective", optional_json(p.result.objective)}, {"figures", figures}};
    for (const std::optional<double>& c : p.captures) point["captures"].push_back(optional_json(c));
    if (!p.result.problem.empty()) point["problem"] = p.result.problem;
    points.push_back(std::move(point));
  }
  return Json{{"name", evaluation.name},
              {"chance", optional_json(evaluation.chance)},
              {"held_out", optional_json(evaluation.held_out)},
              {"converged", evaluation.is_converged},
              {"skipped", evaluation.is_skipped},
              {"points", points}};
}

FitEvaluation read_evaluation(const std::filesystem::path& file, std::size_t num_parameters, std::size_t num_terms) {
  const Json root = load_json(file);
  JsonReader json(file.string(), root);
  FitEvaluation evaluation{.name = json.member("name").string(),
                           .points = {},
                           .chance = read_number_or_null(json.member("chance")),
                           .held_out = read_number_or_null(json.member("held_out")),
                           .is_converged = json.member("converged").boolean(),
                           .is_skipped = json.member("skipped").boolean()};
  for (JsonReader& point : json.member("points").elements(kMaxPoints)) {
    FitPoint p{.values = point.member("values").numbers(num_parameters), .result = {}};
    p.result.objective = read_number_or_null(point.member("objective"));
    const JsonReader figures = point.member("figures");
    for (const JsonReader& f : figures.elements(num_terms)) p.result.figures.push_back(read_number_or_null(f));
    if (p.result.figures.size() != num_terms) figures.fail("an array of " + std::to_string(num_terms));
    if (point.has("captures")) {
      for (const JsonReader& c : point.member("captures").elements(kMaxCaptures))
        p.captures.push_back(read_number_or_null(c));
    }
    if (point.has("problem")) p.result.problem = point.member("problem").string();
    point.finish();
    evaluation.points.push_back(std::move(p));
  }
  json.finish();
  return evaluation;
}

std::string evaluations_csv(std::span<const FitEvaluation> evaluations, std::span<const std::string> parameters,
                            std::span<const std::string> captures, std::span<const FitTerm> terms) {
  std::string text = "evaluation,appearance";
  for (const std::string& p : parameters) text += "," + csv_cell(p);
  text += ",objective";
  for (const std::string& c : captures) text += "," + csv_cell("objective of " + c);
  for (const FitTerm& t : terms) {
    const auto which = static_cast<std::size_t>(t.figure);
    text += "," + csv_cell(std::string(kFitFigureNames[which]) + " [" + std::string(kFitFigureUnits[which]) + "]");
  }
  text += ",problem\n";
  const auto number = [](const std::optional<double>& v) { return v ? number_text(*v) : std::string(); };
  for (const FitEvaluation& e : evaluations) {
    for (std::size_t i = 0; i < e.points.size(); ++i) {
      text += e.name + "," + std::to_string(i);
      for (double v : e.points[i].values) text += "," + number_text(v);
      text += "," + number(e.points[i].result.objective);
      for (std::size_t c = 0; c < captures.size(); ++c)
        text += "," + (c < e.points[i].captures.size() ? number(e.points[i].captures[c]) : std::string());
      for (const std::optional<double>& f : e.points[i].result.figures) text += "," + number(f);
      text += "," + csv_cell(e.points[i].result.problem) + "\n";
    }
  }
  return text;
}

}  // namespace patinate::analysis
