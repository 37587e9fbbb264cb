#include "tools/patinate/study/study_figures.h"

#include <nlohmann/json.hpp>
#include <system_error>

#include "patinate/core/json.h"

namespace patinate::cli {

namespace fs = std::filesystem;

namespace {

void add_numbers(const Json& object, const std::string& prefix, std::vector<StudyFigure>& out) {
  for (const auto& [name, value] : object.items()) {
    if (value.is_number()) out.emplace_back(prefix + name, value.get<double>());
  }
}

void add_listed(const Json& figures, std::vector<StudyFigure>& out) {
  for (const Json& f : figures) {
    if (f.at("value").is_number()) out.emplace_back(f.at("name").get<std::string>(), f.at("value").get<double>());
  }
}

void add_simulation(const Json& json, std::vector<StudyFigure>& out) {
  for (const auto& [material, row] : json.at("ledger").items()) {
    for (const char* column : {"emitted", "on_surfaces", "left"})
      if (row.contains(column)) out.emplace_back(material + " " + column, row.at(column).get<double>());
  }
  for (const auto& [object, facts] : json.at("outcome").at("objects").items()) add_numbers(facts, object + " ", out);
}

void add_fit(const Json& json, std::vector<StudyFigure>& out) {
  add_numbers(
      {{"objective before", json.at("objective").at("before")}, {"objective after", json.at("objective").at("after")}},
      "", out);
  if (json.at("held_out").is_object()) {
    add_numbers(
        {{"held out before", json.at("held_out").at("before")}, {"held out after", json.at("held_out").at("after")}},
        "", out);
  }
  for (const Json& p : json.at("parameters")) {
    const auto name = p.at("pointer").get<std::string>();
    out.emplace_back(name, p.at("best").get<double>());
    out.emplace_back(name + " at least", p.at("interval").at(0).get<double>());
    out.emplace_back(name + " at most", p.at("interval").at(1).get<double>());
  }
}

}  // namespace

std::vector<StudyFigure> figures_of(const fs::path& made) {
  std::vector<StudyFigure> figures;
  std::error_code error;
  const auto has = [&](const char* file) { return fs::is_regular_file(made / file, error); };
  if (has("transfer.json")) add_numbers(load_json(made / "transfer.json").at("energy"), "", figures);
  if (has("simulation.json")) add_simulation(load_json(made / "simulation.json"), figures);
  if (has("evaluation.json")) {
    const Json json = load_json(made / "evaluation.json");
    for (const Json& map : json.at("maps")) add_listed(map.at("figures"), figures);
  }
  if (has("report.json")) {
    const Json json = load_json(made / "report.json");
    if (json.value("format", "") == "patinate.fit") {
      add_fit(json, figures);
    } else if (json.contains("figures")) {
      add_listed(json.at("figures"), figures);
    }
  }
  return figures;
}

}  // namespace patinate::cli
