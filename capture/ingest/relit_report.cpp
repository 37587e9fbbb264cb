// What happened at every step, for people and for programs.
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/ingest/relit_work.h"
#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"

namespace patinate {

namespace fs = std::filesystem;

namespace {

std::string percent(const Json& facts, const char* name) {
  if (!facts.contains(name)) return "-";
  return short_number_text(std::round(1000.0 * facts.at(name).get<double>()) / 10.0) + " %";
}
std::string number(const Json& facts, const char* name, double factor = 1.0) {
  if (!facts.contains(name) || !facts.at(name).is_number()) return "-";
  return short_number_text(rounded(factor * facts.at(name).get<double>(), 3));
}

void add_step(HtmlPage& page, const RelitWork& work, std::size_t index, const Json& facts) {
  page.heading("Step " + std::to_string(work.project.steps[index].number) + ", time " + short_number_text(work.project.steps[index].time) + " " +
               time_unit_text(work.project.time_unit));
  if (!facts.at("in_history").get<bool>()) {
    page.paragraph("Left out: " + facts.at("status").get<std::string>() + ".");
    return;
  }
  page.pictures({{relit_picture_file("light", index).generic_string(), "Under the first light, in the reference view"},
                 {relit_picture_file("albedo", index).generic_string(), "Albedo"},
                 {relit_picture_file("stddev", index).generic_string(), "Its standard deviation: black 0, white 10 %; red: not determined"}});
  page.picture({relit_picture_file("samples", index).generic_string(),
                "Samples: light gray used, black facing away, blue cast shadow, magenta saturated or out of view, cyan too dark, red too bright"});
  if (!facts.contains("lights")) return;
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < facts.at("lights").size(); ++i) {
    const Json& light = facts.at("lights").at(i);
    std::string gain = "-";
    if (i < facts.at("gains").size()) {
      const Json& g = facts.at("gains").at(i);
      gain = short_number_text(rounded(g.at(0).get<double>(), 4)) + " " + short_number_text(rounded(g.at(1).get<double>(), 4)) + " " +
             short_number_text(rounded(g.at(2).get<double>(), 4));
    }
    rows.push_back({std::to_string(i), percent(light, "clean"), percent(light, "unlit"), percent(light, "cast_shadow"), percent(light, "invalid"),
                    percent(light, "darker"), percent(light, "brighter"), percent(light, "residual"), gain});
  }
  page.table({"light", "used", "facing away", "cast shadow", "saturated", "too dark", "too bright", "residual", "gain by the patch"}, rows);
  for (const Json& note : facts.at("notes")) page.paragraph(note.get<std::string>());
}

}  // namespace

void write_relit_report(const RelitWork& work, const fs::path& folder, const std::vector<Json>& facts) {
  Json json{{"format", "patinate.relit"}, {"version", 1}, {"steps", facts}};
  save_json(folder / kRelitReportFile, json);
  HtmlPage page(work.project.name + ": a shape through time");
  page.paragraph(std::to_string(facts.size()) + " steps, " + std::to_string(work.project.lights.size()) + " lights, " +
                 size_text(work.project.width(), work.project.height()) + " pixels. Everything is shown in the view of step " +
                 std::to_string(work.project.steps[work.project.reference].number) + ".");
  std::vector<std::vector<std::string>> rows;
  std::vector<HtmlPicture> albedos;
  for (std::size_t i = 0; i < facts.size(); ++i) {
    const Json& f = facts[i];
    const std::string time = short_number_text(work.project.steps[i].time);
    rows.push_back({std::to_string(work.project.steps[i].number), time, f.at("status").get<std::string>(), number(f, "rms_mm", 1000.0), number(f, "offset_mm", 1000.0),
                    percent(f, "overlap"), percent(f, "seen_share"), percent(f, "determined_share"), percent(f, "residual")});
    if (f.at("in_history").get<bool>()) {
      albedos.push_back({relit_picture_file("albedo", i).generic_string(), time + " " + time_unit_text(work.project.time_unit)});
    }
  }
  page.table({"step", "time", "registration", "RMS (um)", "off the reference (um)", "overlap", "seen", "determined", "residual of the light"}, rows);
  if (!albedos.empty()) page.time_slider(albedos, "Albedo over time");
  for (std::size_t i = 0; i < facts.size(); ++i) add_step(page, work, i, facts[i]);
  page.link(kRelitReportFile, "The same as JSON");
  page.save(folder / kRelitPageFile);
}

}  // namespace patinate
