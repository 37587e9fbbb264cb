#include "analysis/evaluation/evaluation_job.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/report/report_page.h"
#include "libcommon/core/text.h"
#include "libcommon/job/job_inputs.h"
#include "libcommon/output/html_page.h"
#include "patinate/core/error.h"
#include "patinate/image/color.h"

namespace patinate::analysis {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kStageVersion = 3;  ///< Raised when the same input gives other figures.

fs::path item_file(std::size_t i) { return fs::path(kJobWorkFolder) / ("map" + std::to_string(i) + ".json"); }

ImageF source_picture(const SynthesisSource& source) {
  ImageF linear = source.frames.back();
  for (float& v : linear.values()) v = linear_from_srgb(v / 255.0f);
  return linear;
}

Json picture_json(const Picture& picture, const fs::path& scratch) {
  return {{"name", picture.name}, {"caption", picture.caption}, {"source", picture_uri(picture.image, scratch)}};
}

/// One map's part of the report, with its pictures inside.
Json evaluated(const EvaluationItem& item, const EvaluationOptions& options, std::uint64_t seed,
               const fs::path& scratch, const RunControl& control) {
  const MapToEvaluate opened = item.open(control.part(0.0, 0.5));
  Evaluation made =
      evaluate(opened.source, opened.map, options, seed, opened.made ? &*opened.made : nullptr, control.part(0.5, 1.0));
  Json json{{"name", item.name},
            {"about", item.about},
            {"hash", made.hash},
            {"figures", Json::array()},
            {"pictures", Json::array()}};
  for (const Figure& f : opened.more) json["figures"].push_back(figure_json(f));
  for (const Figure& f : made.figures) json["figures"].push_back(figure_json(f));
  json["pictures"].push_back(
      picture_json({"source", "The source at the last of the compared times", source_picture(opened.source)}, scratch));
  for (const Picture& p : made.pictures) json["pictures"].push_back(picture_json(p, scratch));
  return json;
}

std::string cell(const Json& figure) {
  if (figure.at("value").is_null()) return "-";
  std::string text = short_number_text(rounded(figure.at("value").get<double>(), 3));
  if (figure.contains("split")) text += " (" + short_number_text(rounded(figure.at("split").get<double>(), 3)) + ")";
  return text;
}

/// A row for each figure that any map has, a column for each map.
void add_table(HtmlPage& page, const std::vector<Json>& maps) {
  std::vector<std::string> header{"figure"};
  for (const Json& m : maps) header.push_back(m.at("name").get<std::string>());
  header.emplace_back("unit");
  std::vector<std::vector<std::string>> rows;
  std::set<std::string> seen;
  for (const Json& map : maps) {
    for (const Json& figure : map.at("figures")) {
      const auto name = figure.at("name").get<std::string>();
      if (!seen.insert(name).second) continue;
      std::vector<std::string> row{figure.at("title").get<std::string>()};
      for (const Json& other : maps) {
        std::string text;
        for (const Json& f : other.at("figures")) {
          if (f.at("name") == name) text = cell(f);
        }
        row.push_back(text);
      }
      row.push_back(figure.at("unit").get<std::string>());
      rows.push_back(std::move(row));
    }
  }
  page.table(header, rows);
}

void write_report(const fs::path& folder, const EvaluationTask& task, const std::string& key,
                  const std::vector<Json>& maps) {
  HtmlPage page("How good is the texture?");
  page.paragraph(
      "Every texel of a synthesis shows a place of its source; these figures say how well it follows its control, how "
      "well it hangs together, and how much its statistics are the source's. "
      "In brackets: the same for two draws from the source itself, which nothing can be better than. Less is better, "
      "except for the two figures M3, the share used (M6), and those at seams, where 1 is best. "
      "M1 says how far a search went towards the least energy, not how good the texture looks: the least energy is "
      "smooth and repeats itself.");
  add_table(page, maps);
  Json list = Json::array();
  for (const Json& map : maps) {
    page.heading(map.at("name").get<std::string>());
    page.paragraph(map.at("about").get<std::string>());
    std::vector<HtmlPicture> pictures;
    for (const Json& p : map.at("pictures"))
      pictures.push_back({p.at("source").get<std::string>(), p.at("caption").get<std::string>()});
    page.pictures(pictures);
    for (const Json& f : map.at("figures")) {
      if (f.at("value").is_null())
        page.paragraph(f.at("title").get<std::string>() + ": undefined, " + f.at("undefined").get<std::string>() + ".");
    }
    list.push_back({{"name", map.at("name")},
                    {"about", map.at("about")},
                    {"hash", map.at("hash")},
                    {"figures", map.at("figures")}});
  }
  Json options = Json::object();
  for (const auto& [name, value] : option_values(task.options)) options[name] = value;
  options["seed"] = std::to_string(task.seed);
  page.heading("Provenance");
  page.paragraph("This page is repeated, byte for byte, by");
  page.code(task.command);
  page.link(kEvaluationFile, "The figures as JSON");
  page.save(folder / kEvaluationPageFile);
  save_json(folder / kEvaluationFile, Json{{"format", "patinate.evaluation"},
                                           {"version", 2},
                                           {"maps", list},
                                           {"options", options},
                                           {"command", task.command},
                                           {"key", key}});
}

}  // namespace

JobPlan plan_evaluation(EvaluationTask task, const fs::path& output) {
  check_ranges(task.options);
  if (task.maps.empty()) throw InvalidInput("there is no coordinate map to evaluate");
  JobInputs inputs("evaluate", kStageVersion);
  std::set<std::string> names;
  for (const EvaluationItem& map : task.maps) {
    if (!names.insert(map.name).second) throw InvalidInput("two maps are called `" + map.name + "`; give other names");
    inputs.add_content("map", map.name, map.key + " " + map.name);
  }
  inputs.add_options(option_values(task.options));
  inputs.add_value("--seed", std::to_string(task.seed));
  JobPlan plan = inputs.plan(output, kEvaluationFile);
  plan.parallel_items = false;
  const auto shared = std::make_shared<const EvaluationTask>(std::move(task));
  for (std::size_t i = 0; i < shared->maps.size(); ++i) {
    plan.items.push_back({.name = "map" + std::to_string(i),
                          .outputs = part_files(item_file(i)),
                          .run = [shared, i](const fs::path& folder, const RunControl& control) {
                            fs::create_directories(folder / kJobWorkFolder);
                            save_part(
                                folder / item_file(i),
                                evaluated(shared->maps[i], shared->options, shared->seed,
                                          folder / kJobWorkFolder / ("map" + std::to_string(i) + ".png"), control));
                          }});
  }
  plan.join = [shared, key = plan.key](const fs::path& folder, const RunControl&) {
    std::vector<Json> maps;
    for (std::size_t i = 0; i < shared->maps.size(); ++i) maps.push_back(load_part(folder / item_file(i)));
    write_report(folder, *shared, key, maps);
  };
  return plan;
}

}  // namespace patinate::analysis
